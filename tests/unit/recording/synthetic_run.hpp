// A run with exact truth, as the pipeline would report it: a moving camera, moving objects, points that begin and end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/recording/run_recorder.hpp"

namespace kinetrace::recording {

/// A folder that disappears with the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

struct SyntheticObject {
  std::uint32_t track_id = 1;
  std::uint16_t class_id = 1;
  int first_frame = 0;
  int last_frame = 1000000;
  BodyStatus status = BodyStatus::kTracked;
  int points = 5;
};

struct SyntheticRunConfig {
  int frames = 12;
  int settling_lag = 4;
  int background_points = 30;
  int point_life_frames = 6;  ///< Background points are replaced in turn after so many frames.
  std::vector<SyntheticObject> objects{};
  std::string name_prefix{};  ///< Frames are named prefix + number; empty: no names.
};

/// Makes the results one by one; spans stay valid until the next one.
class SyntheticRun {
 public:
  static constexpr int kWidth = 320;
  static constexpr int kHeight = 120;

  explicit SyntheticRun(SyntheticRunConfig config);

  [[nodiscard]] static StereoGeometry geometry();
  [[nodiscard]] static Se3 T_world_cam(int frame);
  [[nodiscard]] static Se3 T_world_obj(std::uint32_t track_id, int frame);
  [[nodiscard]] static Box3 box(std::uint32_t track_id, int frame);
  [[nodiscard]] static PixelBox mask_box(std::size_t slot, int frame);
  [[nodiscard]] static std::int64_t timestamp_ns(int frame) {
    return 1'700'000'000'000'000'001 + std::int64_t{frame} * 100'000'000;
  }
  /// Position of a point in its body's frame, from its id alone.
  [[nodiscard]] static Eigen::Vector3f point_position(std::uint32_t track_id, std::uint32_t point_id);

  /// Result of the next frame, then the drained ones, then nullptr.
  [[nodiscard]] const FrameResult* next();
  /// Hands everything to the recorder; stops at the first error.
  [[nodiscard]] Status play(RunRecorder& recorder);

 private:
  struct LivePoint {
    std::uint32_t track_id;
    std::uint32_t id;
    int born;
  };
  struct Body {
    std::vector<BodyPoint> points;
    std::vector<BodyPoint> retired;
    std::vector<PointObservation> observations;
  };
  void estimate(int frame, FrameEstimate& out, std::vector<ObjectResult>& objects) const;
  void renew_points(int frame, bool is_last);
  void fill_bodies(int frame, bool with_observations);
  void paint_labels(int frame);

  SyntheticRunConfig config_;
  int step_ = 0;
  std::uint32_t next_point_id_ = 1;
  std::vector<LivePoint> live_;
  std::vector<Body> body_data_;  ///< Background, then one per configured object.
  std::vector<ObjectResult> newest_objects_, finalised_objects_;
  std::vector<BodyGeometry> bodies_;
  std::vector<Track> tracks_;
  std::vector<std::uint8_t> labels_;
  std::string name_;
  FrameResult result_;
};

/// A recorder with an arena of exactly the size it asks for.
struct RecorderFixture {
  explicit RecorderFixture(const RecordingConfig& config)
      : arena(RunRecorder::required_bytes(config)), recorder(RunRecorder::create(config, arena)) {}
  Arena arena;
  Result<RunRecorder> recorder;
};

[[nodiscard]] RecordingConfig recording_config(const std::filesystem::path& directory);

/// A finished run folder.
[[nodiscard]] Status record_all(const RecordingConfig& recording, const SyntheticRunConfig& run);

}  // namespace kinetrace::recording
