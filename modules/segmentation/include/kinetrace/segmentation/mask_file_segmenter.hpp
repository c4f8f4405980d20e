// Instance masks from files beside a recording.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/segmentation/instance_image.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "kinetrace/segmentation/warning_log.hpp"

namespace kinetrace::imaging {
class ImageReader;
}

namespace kinetrace::segmentation {

/// One PNG per frame and view, named like the image: KITTI MOTS (16 bit) or plain instance numbers (8 bit). Numbers in
/// files are detections of one frame, never identities. The only class of the module that reads files, in load() alone.
class MaskFileSegmenter final : public Segmenter {
 public:
  [[nodiscard]] static std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry);
  /// Errors: kInvalidConfig, kNotFound (a folder is missing or holds no .png), kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<MaskFileSegmenter>> create(const SegmentationConfig& config,
                                                                         const StereoGeometry& geometry, Arena& arena);

  ~MaskFileSegmenter() override;

  /// Reads the masks of `pair.name`. A missing left file leaves the frame without detections and is counted; a missing
  /// right one leaves the right masks to the tracker; a file that is damaged or of another size is counted and leaves
  /// the frame without detections. Allocates only for an error's message.
  void load(const RectifiedPair& pair, std::span<const Track> tracks) override;

  /// Renumbers the loaded masks. Errors: kIllegalState if load() was not called for this frame.
  [[nodiscard]] Result<DetectionFrame> process(const SegmentationInput& input) override;
  void reset() override;

  [[nodiscard]] std::size_t warning_count() const noexcept override { return warnings_.size(); }
  [[nodiscard]] std::string_view warning(std::size_t index) const noexcept override { return warnings_[index]; }

 private:
  enum class FileState : std::uint8_t { kMissing, kUnreadable, kLoaded };
  struct View {
    std::string directory;  ///< Empty: no masks for this view.
    FileState state = FileState::kMissing;
    MaskEncoding encoding = MaskEncoding::kMots;
    ImageView<std::uint16_t> values;
    MutableLabelView labels;
    FixedVector<Detection> detections;
  };

  MaskFileSegmenter();
  static void carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                    MaskFileSegmenter& segmenter);
  void load_view(View& view, std::string_view stem);
  void relabel(View& view, std::string_view stem) noexcept;

  static constexpr std::size_t kMaxPathBytes = 4096;

  SegmentationConfig config_;
  View left_;
  View right_;
  InstanceRelabeler relabeler_;
  std::unique_ptr<imaging::ImageReader> reader_;
  std::array<char, kMaxPathBytes> path_{};
  bool loaded_ = false;
  std::int64_t loaded_frame_index_ = 0;
  WarningLog warnings_;
};

}  // namespace kinetrace::segmentation
