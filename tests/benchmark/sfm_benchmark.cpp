// Pose from known points, with OpenCV for comparison, and the calls of one body for a window of ten frames.
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>

#include "body_driver.hpp"
#include "kinetrace/sfm/stereo_pose_estimator.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

using kinetrace::test::driven;
using kinetrace::test::street_rig;
using kinetrace::test::SyntheticWorld;

/// Observations of known points by the rig, some of them wrong.
struct PoseProblem {
  StereoGeometry rig = street_rig();
  Se3 T_cam_body{so3_exp({0.02, -0.1, 0.01}), {0.3, -0.1, 0.8}};
  std::vector<PoseObservation> observations;
};

PoseProblem make_problem(int points, double outlier_ratio) {
  PoseProblem problem;
  std::mt19937 engine(7);
  std::normal_distribution<double> noise(0.0, 0.3);
  const auto uniform = [&engine](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  for (int i = 0; i < points; ++i) {
    const double z = 5.0 * std::pow(12.0, uniform(0.0, 1.0));
    const Eigen::Vector3d p_cam =
        problem.rig.triangulate(uniform(0.0, 1242.0), uniform(0.0, 375.0), problem.rig.disparity_px(z));
    const bool wrong = i < outlier_ratio * points;
    const Eigen::Vector3d uvr =
        problem.rig.project(p_cam) + Eigen::Vector3d(noise(engine), noise(engine), noise(engine));
    problem.observations.push_back({.p_body = problem.T_cam_body.inverse() * p_cam,
                                    .u_left_px = static_cast<float>(wrong ? uniform(0.0, 1242.0) : uvr.x()),
                                    .v_px = static_cast<float>(wrong ? uniform(0.0, 375.0) : uvr.y()),
                                    .u_right_px = static_cast<float>(uvr.z())});
  }
  return problem;
}

double position_error_m(const PoseProblem& problem, const Se3& T_cam_body) {
  return (T_cam_body.inverse().translation - problem.T_cam_body.inverse().translation).norm();
}

/// Starts at the identity, .8 m and 6 degrees off.
void BM_StereoPose(benchmark::State& state) {
  const PoseProblem problem =
      make_problem(static_cast<int>(state.range(0)), 0.01 * static_cast<double>(state.range(1)));
  const StereoPoseEstimator estimator({}, problem.rig);
  std::vector<std::uint8_t> inlier(problem.observations.size());
  PoseEstimate pose;
  for (auto _ : state) {
    pose = estimator.estimate(problem.observations, {}, 0.4, inlier);
    benchmark::DoNotOptimize(pose);
  }
  state.counters["error_mm"] = 1e3 * position_error_m(problem, pose.T_cam_body);
  state.counters["inliers"] = pose.inliers;
}
BENCHMARK(BM_StereoPose)
    ->ArgNames({"points", "outlier_percent"})
    ->Args({100, 40})
    ->Args({600, 0})
    ->Args({600, 40})
    ->Unit(benchmark::kMicrosecond);

void BM_OpenCvPnpRansac(benchmark::State& state) {
  const PoseProblem problem =
      make_problem(static_cast<int>(state.range(0)), 0.01 * static_cast<double>(state.range(1)));
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const PoseObservation& o : problem.observations) {
    points.emplace_back(o.p_body.x(), o.p_body.y(), o.p_body.z());
    pixels.emplace_back(o.u_left_px, o.v_px);
  }
  const StereoGeometry& rig = problem.rig;
  const cv::Matx33d camera(rig.fx_px, 0, rig.cx_px, 0, rig.fy_px, rig.cy_px, 0, 0, 1);
  cv::Vec3d rotation;
  cv::Vec3d translation;
  std::vector<int> inliers;
  for (auto _ : state) {
    cv::solvePnPRansac(points, pixels, camera, cv::noArray(), rotation, translation, false, 100, 1.6F, 0.99, inliers,
                       static_cast<int>(state.range(2)));
    benchmark::DoNotOptimize(translation);
  }
  const Se3 T_cam_body{so3_exp({rotation[0], rotation[1], rotation[2]}),
                       {translation[0], translation[1], translation[2]}};
  state.counters["error_mm"] = 1e3 * position_error_m(problem, T_cam_body);
  state.counters["inliers"] = static_cast<double>(inliers.size());
}
BENCHMARK(BM_OpenCvPnpRansac)
    ->ArgNames({"points", "outlier_percent", "method"})
    ->Args({100, 40, cv::SOLVEPNP_EPNP})
    ->Args({100, 40, cv::SOLVEPNP_P3P})
    ->Args({100, 40, cv::USAC_DEFAULT})
    ->Args({600, 40, cv::USAC_DEFAULT})
    ->Unit(benchmark::kMicrosecond);

/// Frames of a drive, recorded once: simulating them costs more than the measured calls.
std::vector<std::vector<Feature>> record_drive(int features, int frames) {
  SyntheticWorld world({.background_features = features, .wrong_track_ratio = 0.05});
  std::vector<std::vector<Feature>> recorded;
  for (int i = 0; i < frames; ++i) {
    const FeatureFrame frame = world.observe(driven(0.8 * i, 0.005));
    recorded.emplace_back(frame.features.begin(), frame.features.end());
  }
  return recorded;
}

enum class Part { kLocate, kExtendAndConclude, kAllWithRefinement };

/// One frame in a full window of ten.
void body_frame(benchmark::State& state, Part part) {
  constexpr int kFrames = 40;
  const int features = static_cast<int>(state.range(0));
  std::vector<std::vector<Feature>> recorded = record_drive(features, kFrames);
  BodyConfig config;
  config.max_points = 2 * features;
  test::BodyDriver driver(config);
  driver.refine(part != Part::kExtendAndConclude);
  int i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    if (i == kFrames) {
      driver.body().end();
      i = 0;
    }
    for (bool timed = false; !timed; ++i) {
      const FeatureFrame frame{i, 100'000'000LL * i, recorded[static_cast<std::size_t>(i)]};
      timed = i >= 15;
      if (timed && part != Part::kExtendAndConclude) {
        state.ResumeTiming();
      }
      if (i == 0) {
        driver.body().begin({});
      } else {
        driver.body().locate(frame, 0);
      }
      if (timed && part == Part::kLocate) {
        state.PauseTiming();
      } else if (timed && part == Part::kExtendAndConclude) {
        state.ResumeTiming();
      }
      driver.finish(frame);
    }
    if (part == Part::kLocate) {
      state.ResumeTiming();
    }
  }
  state.counters["points"] = static_cast<double>(driver.body().estimate().points.size());
}

void BM_Locate(benchmark::State& state) {
  body_frame(state, Part::kLocate);
}
BENCHMARK(BM_Locate)->Arg(60)->Arg(600)->Unit(benchmark::kMicrosecond);

void BM_ExtendAndConclude(benchmark::State& state) {
  body_frame(state, Part::kExtendAndConclude);
}
BENCHMARK(BM_ExtendAndConclude)->Arg(60)->Arg(600)->Unit(benchmark::kMicrosecond);

void BM_FrameWithRefinement(benchmark::State& state) {
  body_frame(state, Part::kAllWithRefinement);
}
BENCHMARK(BM_FrameWithRefinement)->Arg(60)->Arg(600)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace kinetrace::sfm
