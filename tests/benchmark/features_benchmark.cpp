// The feature front end stage by stage on 1242 x 375 images, with the OpenCV equivalent.
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "kinetrace/features/feature_front_end.hpp"
#include "synthetic_scene.hpp"

namespace {

using kinetrace::Arena;
using kinetrace::FeatureFrame;
using kinetrace::FeaturePrediction;
using kinetrace::GrayView;
using kinetrace::RectifiedPair;
using kinetrace::features::FeatureConfig;
using kinetrace::features::FeatureFrontEnd;
using kinetrace::features::testing::Scene;
using kinetrace::features::testing::StereoImage;
using kinetrace::features::testing::Texture;

constexpr int kWidth = 1242;
constexpr int kHeight = 375;
const Eigen::Vector2d kShift(12.3, 2.7);

/// Two frames of a moving, noisy, slanted plane.
struct Video {
  StereoImage frames[2];

  static const Video& instance() {
    static const Video video;
    return video;
  }

 private:
  Video() : frames{rendered(0), rendered(1)} {}
  static StereoImage rendered(unsigned index) {
    const Texture texture(3);
    Scene scene;
    scene.width = kWidth;
    scene.height = kHeight;
    scene.noise_gray = 2.0;
    scene.disparity = {25.0, {0.0, 0.1}, {0.5 * kWidth, 0.5 * kHeight}};
    scene.left = [&](const Eigen::Vector2d& p) { return texture(p - static_cast<double>(index) * kShift); };
    return scene.render(index + 1);
  }
};

FeatureConfig thousand_features() {
  FeatureConfig config;
  config.bucket_px = 20;
  config.max_background_features = 1000;
  return config;
}

/// A front end that has seen the first frame.
class Session {
 public:
  Session()
      : arena_(FeatureFrontEnd::required_bytes(thousand_features(), kWidth, kHeight)),
        front_end_(FeatureFrontEnd::create(thousand_features(), kWidth, kHeight, arena_).value()) {
    restart();
  }
  FeatureFrontEnd& operator*() { return front_end_; }
  FeatureFrontEnd* operator->() { return &front_end_; }

  void begin(int frame) {
    if (!front_end_.begin_frame(Video::instance().frames[frame].pair(frame))) {
      std::abort();
    }
  }
  /// New features of frame 0, and frame 1 begun; predictions are off by `error_px`.
  void restart(float error_px = 2.F) {
    front_end_.reset();
    begin(0);
    benchmark::DoNotOptimize(front_end_.track({}));
    const FeatureFrame frame = front_end_.replenish({}).value();
    predictions_.assign(static_cast<std::size_t>(thousand_features().max_features), {});
    for (const auto& feature : frame.features) {
      const Eigen::Vector2f error(error_px, 0.F);
      predictions_[feature.slot] = {feature.left_px + kShift.cast<float>() + error, feature.disparity_px(), true};
    }
    count_ = frame.features.size();
    begin(1);
  }
  [[nodiscard]] const std::vector<FeaturePrediction>& predictions() const { return predictions_; }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  Arena arena_;
  FeatureFrontEnd front_end_;
  std::vector<FeaturePrediction> predictions_;
  std::size_t count_ = 0;
};

cv::Mat as_mat(const GrayView& view) {
  // OpenCV has no view of constant pixels; this one is never written.
  return {view.height, view.width, CV_8U, const_cast<std::uint8_t*>(view.data), static_cast<std::size_t>(view.stride)};
}
cv::Mat left(int frame) {
  return as_mat(Video::instance().frames[frame].left.view());
}
cv::Mat right(int frame) {
  return as_mat(Video::instance().frames[frame].right.view());
}
std::vector<cv::Point2f> corners() {
  std::vector<cv::Point2f> points;
  cv::goodFeaturesToTrack(left(0), points, 1000, 0.001, 10);
  return points;
}

void BM_BeginFrame(benchmark::State& state) {
  Session session;
  for (auto _ : state) {
    session.begin(1);
  }
}
BENCHMARK(BM_BeginFrame)->Unit(benchmark::kMillisecond);

void BM_BeginFrame_OpenCvPyramids(benchmark::State& state) {
  cv::setNumThreads(1);
  std::vector<cv::Mat> pyramid;
  for (auto _ : state) {
    cv::buildPyramid(left(0), pyramid, 3);
    cv::buildPyramid(right(0), pyramid, 3);
  }
}
BENCHMARK(BM_BeginFrame_OpenCvPyramids)->Unit(benchmark::kMillisecond);

/// Forward, reference patch, backward, and left-right of the survivors.
void track(benchmark::State& state, bool predicted) {
  Session session;
  for (auto _ : state) {
    state.PauseTiming();
    session.restart();
    state.ResumeTiming();
    benchmark::DoNotOptimize(session->track(predicted ? session.predictions() : std::vector<FeaturePrediction>{}));
  }
  state.counters["features"] = static_cast<double>(session.count());
  state.counters["tracked"] = static_cast<double>(session->counters().tracked);
  state.counters["stereo"] = static_cast<double>(session->counters().stereo_matched) /
                             static_cast<double>(session->counters().stereo_attempted);
}
void BM_TrackAndMatch_Predicted(benchmark::State& state) {
  track(state, true);
}
BENCHMARK(BM_TrackAndMatch_Predicted)->Unit(benchmark::kMillisecond);

void BM_TrackAndMatch_Unpredicted(benchmark::State& state) {
  track(state, false);
}
BENCHMARK(BM_TrackAndMatch_Unpredicted)->Unit(benchmark::kMillisecond);

void BM_Track_OpenCvLucasKanade_ForwardBackward(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<cv::Point2f> from = corners();
  std::vector<cv::Point2f> to;
  std::vector<cv::Point2f> back;
  std::vector<std::uint8_t> status;
  std::vector<float> error;
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.02);
  for (auto _ : state) {
    cv::calcOpticalFlowPyrLK(left(0), left(1), from, to, status, error, cv::Size(15, 11), 3, criteria);
    cv::calcOpticalFlowPyrLK(left(1), left(0), to, back, status, error, cv::Size(15, 11), 3, criteria);
  }
  state.counters["features"] = static_cast<double>(from.size());
}
BENCHMARK(BM_Track_OpenCvLucasKanade_ForwardBackward)->Unit(benchmark::kMillisecond);

void BM_Match_OpenCvBlockMatching(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto matcher = cv::StereoBM::create(128, 15);
  cv::Mat disparity;
  for (auto _ : state) {
    matcher->compute(left(0), right(0), disparity);
  }
}
BENCHMARK(BM_Match_OpenCvBlockMatching)->Unit(benchmark::kMillisecond);

void BM_Match_OpenCvSemiGlobal(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto matcher = cv::StereoSGBM::create(0, 128, 5);
  cv::Mat disparity;
  for (auto _ : state) {
    matcher->compute(left(0), right(0), disparity);
  }
}
BENCHMARK(BM_Match_OpenCvSemiGlobal)->Unit(benchmark::kMillisecond)->Iterations(5);

/// All features live: only the corner pass and the bookkeeping.
void BM_Replenish_Steady(benchmark::State& state) {
  Session session;
  for (auto _ : state) {
    state.PauseTiming();
    session.restart();
    benchmark::DoNotOptimize(session->track(session.predictions()));
    state.ResumeTiming();
    benchmark::DoNotOptimize(session->replenish({}));
  }
}
BENCHMARK(BM_Replenish_Steady)->Unit(benchmark::kMillisecond);

/// The first frame: corners for all, each with a full left-right search.
void BM_Replenish_FirstFrame(benchmark::State& state) {
  Session session;
  for (auto _ : state) {
    state.PauseTiming();
    session->reset();
    session.begin(0);
    benchmark::DoNotOptimize(session->track({}));
    state.ResumeTiming();
    benchmark::DoNotOptimize(session->replenish({}));
  }
  state.counters["created"] = static_cast<double>(session->counters().created);
}
BENCHMARK(BM_Replenish_FirstFrame)->Unit(benchmark::kMillisecond);

void BM_Corners_OpenCvGoodFeatures(benchmark::State& state) {
  cv::setNumThreads(1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(corners());
  }
}
BENCHMARK(BM_Corners_OpenCvGoodFeatures)->Unit(benchmark::kMillisecond);

void BM_Corners_OpenCvFast(benchmark::State& state) {
  cv::setNumThreads(1);
  std::vector<cv::KeyPoint> points;
  for (auto _ : state) {
    cv::FAST(left(0), points, 20);
  }
  state.counters["corners"] = static_cast<double>(points.size());
}
BENCHMARK(BM_Corners_OpenCvFast)->Unit(benchmark::kMillisecond);

}  // namespace
