// Object tracking, assignment and motion segmentation at the sizes of a full street scene.
#include <array>
#include <memory>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "kinetrace/segmentation/segmenter.hpp"
#include "kinetrace/tracking/assignment.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"
#include "synthetic_world.hpp"

namespace kinetrace {
namespace {

void assign_32x32(benchmark::State& state) {
  auto affinity = std::make_unique<tracking::AffinityMatrix>();
  affinity->resize(32, 32);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> weight(0.0, 1.0);
  for (int u = 0; u < 32; ++u) {
    for (int v = 0; v < 32; ++v) {
      (*affinity)(u, v) = weight(random);
    }
  }
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(tracking::maximum_weight_assignment(*affinity));
  }
}
BENCHMARK(assign_32x32)->Unit(benchmark::kMicrosecond);

constexpr int kObjects = 8;
constexpr int kObjectWidth = 150;
constexpr int kObjectHeight = 100;

/// Eight boxes of 150 x 100 px in two rows that move 4 px a frame, each with 60 features.
struct Boxes {
  StereoGeometry geometry = test::street_rig();
  std::vector<std::uint8_t> pixels;
  std::vector<Detection> detections;
  std::vector<Feature> features;

  explicit Boxes(int frame) {
    const int width = geometry.width_px;
    pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(geometry.height_px));
    for (int k = 0; k < kObjects; ++k) {
      const int x0 = 30 + 290 * (k % 4) + 4 * frame;
      const int y0 = 40 + 160 * (k / 4);
      const auto label = static_cast<std::uint8_t>(k + 1);
      for (int y = y0; y < y0 + kObjectHeight; ++y) {
        std::fill_n(
            &pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x0)],
            kObjectWidth, label);
      }
      detections.push_back(
          {label, kVehicleClass, 1.F, {x0, y0, x0 + kObjectWidth, y0 + kObjectHeight}, kObjectWidth * kObjectHeight});
      for (int i = 0; i < 60; ++i) {
        const int row = i / 10;
        Feature f;
        f.body = label;
        f.age_frames = 3;
        f.left_px = {static_cast<float>(x0 + 5 + 14 * (i % 10)), static_cast<float>(y0 + 5 + 16 * row)};
        f.previous_left_px = f.left_px - Eigen::Vector2f(4.F, 0.F);
        f.u_right_px = f.left_px.x() - 12.F;
        features.push_back(f);
      }
    }
  }
  [[nodiscard]] DetectionFrame frame(bool available) const {
    DetectionFrame out;
    out.available = available;
    if (available) {
      out.left_labels = {pixels.data(), geometry.width_px, geometry.height_px, geometry.width_px};
      out.left = detections;
    }
    return out;
  }
};

void track_8_objects(benchmark::State& state) {
  const bool with_right = state.range(0) != 0;
  const bool detected = state.range(1) != 0;
  std::vector<Boxes> frames;
  frames.reserve(8);
  for (int i = 0; i < 8; ++i) {
    frames.emplace_back(i);
  }
  const StereoGeometry& g = frames[0].geometry;
  tracking::TrackerConfig config;
  config.max_missed_s = 100.0;
  Arena arena(tracking::StereoTracker::required_bytes(config, g.width_px, g.height_px));
  auto tracker = tracking::StereoTracker::create(config, g.width_px, g.height_px, arena).value();
  std::int64_t timestamp_ns = 0;
  const auto process = [&](const Boxes& boxes, bool available) {
    DetectionFrame frame = boxes.frame(available);
    if (with_right) {
      frame.right_labels = frame.left_labels;
      frame.right = frame.left;
    }
    benchmark::DoNotOptimize(tracker.process(timestamp_ns += kUsualInterval_ns, frame, boxes.features));
  };
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    tracker.reset();
    for (int i = 0; i < 4; ++i) {
      process(frames[static_cast<std::size_t>(i)], true);
    }
    state.ResumeTiming();
    process(frames[4], detected);
  }
}
BENCHMARK(track_8_objects)
    ->ArgNames({"right_masks", "detected"})
    ->Args({0, 1})
    ->Args({1, 1})
    ->Args({0, 0})
    ->Unit(benchmark::kMillisecond);

void segment_motion(benchmark::State& state) {
  test::WorldConfig world_config;
  world_config.background_features = static_cast<int>(state.range(0)) - 120;
  world_config.capacity = 4000;
  world_config.wrong_track_ratio = 0.05;
  world_config.wrong_right_ratio = 0.05;
  test::SyntheticWorld world(world_config, {{{4.0, 1.5, 1.8}, 60}, {{4.0, 1.5, 1.8}, 60}});
  segmentation::SegmentationConfig config;
  config.mode = segmentation::SegmentationMode::kMotion;
  Arena arena(segmentation::required_bytes(config, world_config.geometry, world_config.capacity));
  const auto segmenter =
      segmentation::make_segmenter(config, world_config.geometry, world_config.capacity, arena).value();
  std::vector<std::vector<Feature>> frames;
  for (int i = 0; i < 24; ++i) {
    const FeatureFrame frame =
        world.observe(test::driven(0.5 * i), std::array{test::turned(0.0, {-6.0 + 0.5 * i, 0.6, 12.0 + 0.5 * i}),
                                                        test::turned(0.0, {6.0 - 0.3 * i, 0.6, 20.0 + 0.5 * i})});
    frames.emplace_back(frame.features.begin(), frame.features.end());
  }
  std::size_t next = frames.size();
  std::size_t detections = 0;
  for ([[maybe_unused]] auto _ : state) {
    if (next == frames.size()) {
      segmenter->reset();
      next = 0;
    }
    segmentation::SegmentationInput input;
    input.features = frames[next];
    input.pair.timestamp_ns = static_cast<std::int64_t>(next) * 100'000'000;
    input.ego_valid = next > 0;
    input.T_prev_cam = test::driven(0.5);
    ++next;
    detections += segmenter->process(input)->left.size();
  }
  state.counters["detections"] =
      benchmark::Counter(static_cast<double>(detections), benchmark::Counter::kAvgIterations);
}
BENCHMARK(segment_motion)->Arg(400)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kinetrace
