#include "self_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include <Eigen/LU>

#include "point_pairs.hpp"
#include "rough_rig.hpp"
#include "track_finder.hpp"
#include "view_warp.hpp"
#include "window_start.hpp"

namespace kinetrace::self_calibration {
namespace {

cv::Mat to_opencv(GrayView image) {
  return cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                 static_cast<std::size_t>(image.stride));
}

struct PooledPairs {
  ImageSize size;
  std::vector<PointPair> pairs;
};

Result<PooledPairs> pool_pairs(const FrameSource& source, std::size_t count) {
  PooledPairs pooled;
  count = std::min(count, source.frames);
  for (std::size_t i = 0; i < count; ++i) {
    const Result<StereoFrame> frame = source.read((2 * i + 1) * source.frames / (2 * count));
    if (!frame) {
      return Unexpected(frame.error());
    }
    pooled.size = {frame->left.width, frame->left.height};
    const std::vector<PointPair> pairs = find_point_pairs(to_opencv(frame->left), to_opencv(frame->right));
    pooled.pairs.insert(pooled.pairs.end(), pairs.begin(), pairs.end());
  }
  return pooled;
}

/// What the first matches allow, and as much again where nothing was matched.
StereoSearch search_range(const ViewWarp& warp, const std::vector<PointPair>& inliers, int rows_px) {
  std::vector<double> disparities;
  for (const PointPair& pair : inliers) {
    disparities.push_back((warp.to_warped(0, pair.left_px) - warp.to_warped(1, pair.right_px)).x());
  }
  std::sort(disparities.begin(), disparities.end());
  const std::size_t few = disparities.size() / 100;
  const double least = disparities[few];
  const double most = disparities[disparities.size() - 1 - few];
  return {least - 6.0 - 0.1 * (most - least), most + 10.0 + 0.3 * (most - least), rows_px};
}

Result<std::vector<TrackWindow>> find_tracks(const FrameSource& source, const ViewWarp& warp,
                                             const StereoSearch& search, std::size_t most,
                                             const SelfCalibrationOptions& options) {
  std::vector<TrackWindow> windows;
  const std::size_t length = std::min(options.frames_per_window, source.frames);
  const std::size_t count = std::max<std::size_t>(1, std::min(most, source.frames / length));
  for (std::size_t w = 0; w < count; ++w) {
    const std::size_t first = count == 1 ? 0 : w * (source.frames - length) / (count - 1);
    TrackFinder finder(warp, search);
    for (std::size_t place = first; place < first + length; ++place) {
      const Result<StereoFrame> frame = source.read(place);
      if (!frame) {
        return Unexpected(frame.error());
      }
      finder.add(*frame, place);
    }
    windows.push_back(finder.take());
  }
  return windows;
}

std::vector<BundleWindow> start_windows(const RigModel& rig, const std::vector<TrackWindow>& tracks) {
  std::vector<BundleWindow> windows;
  for (const TrackWindow& window : tracks) {
    if (std::optional<BundleWindow> started = start_window(rig, window)) {
      windows.push_back(std::move(*started));
    }
  }
  return windows;
}

/// Scatter of a coordinate: 1.48 times the median magnitude.
double robust_sigma_px(const RigModel& rig, const std::vector<BundleWindow>& windows) {
  std::vector<double> magnitudes;
  for (const BundleWindow& window : windows) {
    for (const BundlePoint& point : window.points) {
      if (point.used) {
        for (const Observation& seen : point.observations) {
          const Eigen::Vector2d r = residual_px(rig, window, point, seen);
          magnitudes.push_back(std::abs(r.x()));
          magnitudes.push_back(std::abs(r.y()));
        }
      }
    }
  }
  if (magnitudes.empty()) {
    return 1.0;
  }
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  return 1.4826 * *middle;
}

/// Whole tracks go: what moves by itself, or was followed wrongly, is wrong in all its observations.
void reject_tracks(const RigModel& rig, std::vector<BundleWindow>& windows, double sigma_px) {
  constexpr double kRmsSigmas = 3.0;
  constexpr double kWorstSigmas = 8.0;
  for (BundleWindow& window : windows) {
    for (BundlePoint& point : window.points) {
      double sum2 = 0.0;
      double worst = 0.0;
      for (const Observation& seen : point.observations) {
        const double r2 = 0.5 * residual_px(rig, window, point, seen).squaredNorm();
        sum2 += r2;
        worst = std::max(worst, r2);
      }
      const double rms = std::sqrt(sum2 / static_cast<double>(point.observations.size()));
      point.used = point.used && point.ray_and_inverse_depth[2] > 0.0 && rms < kRmsSigmas * sigma_px &&
                   std::sqrt(worst) < kWorstSigmas * sigma_px;
    }
  }
}

std::string describe(const RigModel& rig) {
  std::string text;
  char line[256];
  for (const LensBlock& l : rig.lens) {
    const double f = rig.size.width_px * std::exp(l[kLogFocal]);
    std::snprintf(line, sizeof line, "f %.2f a %.4f c %.2f %.2f k %.4f %.4f %.4f p %.5f %.5f | ", f,
                  std::exp(l[kLogAspect]), l[kOffsetX] * rig.size.width_px, l[kOffsetY] * rig.size.width_px, l[kK1],
                  l[kK2], l[kK3], l[kP1], l[kP2]);
    text += line;
  }
  std::snprintf(line, sizeof line, "turn %.5f %.5f %.5f base %.5f %.5f", rig.mount[0], rig.mount[1], rig.mount[2],
                rig.mount[3], rig.mount[4]);
  return text + line;
}

/// One solution, then the scatter of its observations and the tracks that do not fit.
Status adjust_and_reject(RigModel& rig, std::vector<BundleWindow>& windows, BundleOptions& bundle,
                         const SelfCalibrationOptions& options) {
  const Result<BundleResult> result = adjust(rig, windows, bundle);
  if (!result) {
    return Unexpected(result.error());
  }
  bundle.sigma_px = robust_sigma_px(rig, windows);
  reject_tracks(rig, windows, bundle.sigma_px);
  char line[200];
  std::snprintf(line, sizeof line, "iterations %d cost %.1f sigma %.4f px; ", result->iterations, result->cost,
                bundle.sigma_px);
  options.progress(line + describe(rig));
  return {};
}

/// From a rig that may be far off: few iterations between rejections, which would otherwise hold it.
Result<double> adjust_in_rounds(RigModel& rig, std::vector<BundleWindow>& windows,
                                const SelfCalibrationOptions& options, bool rough) {
  struct Round {
    bool rig_fixed;
    int iterations;
    double tolerance;
  };
  static constexpr std::array<Round, 4> kRough{{{false, 20, 1e-4}, {false, 20, 1e-4}, {false, 20, 1e-5}, {false, 30, 1e-5}}};
  static constexpr std::array<Round, 4> kFine{{{true, 15, 1e-4}, {false, 20, 1e-5}, {false, 30, 1e-5}, {false, 40, 1e-6}}};
  BundleOptions bundle;
  bundle.priors = options.priors;
  bundle.threads = options.threads;
  for (const Round& round : rough ? kRough : kFine) {
    bundle.rig_fixed = round.rig_fixed;
    bundle.iterations = round.iterations;
    bundle.tolerance = round.tolerance;
    if (const Status done = adjust_and_reject(rig, windows, bundle, options); !done) {
      return Unexpected(done.error());
    }
  }
  return bundle.sigma_px;
}

void add_covariance(SelfCalibration& found, const SelfCalibrationOptions& options) {
  BundleOptions bundle;
  bundle.priors = options.priors;
  bundle.sigma_px = found.sigma_px;
  const RigInformation prior = prior_information(found.rig, options.priors);
  Eigen::Matrix<double, kRigSize, kRigSize> normal = prior.normal;
  Eigen::Matrix<double, kRigSize, kRigSize> scatter = Eigen::Matrix<double, kRigSize, kRigSize>::Zero();
  for (const BundleWindow& window : found.windows) {
    const RigInformation part = rig_information(found.rig, window, bundle);
    normal += part.normal;
    scatter += part.gradient * part.gradient.transpose();
  }
  const Eigen::Matrix<double, kRigSize, kRigSize> inverse = normal.inverse();
  const auto n = static_cast<double>(found.windows.size());
  found.covariance = n / std::max(n - 1.0, 1.0) * inverse * scatter * inverse;
  const auto names = {"lnf", "asp", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  std::string text = "sigma formal/scatter: ";
  int i = 0;
  for (const char* name : names) {
    char line[100];
    std::snprintf(line, sizeof line, "%s %.6f/%.6f ", name, std::sqrt(inverse(i, i)),
                  std::sqrt(found.covariance(i, i)));
    text += line;
    ++i;
  }
  for (i = 18; i < kRigSize; ++i) {
    char line[100];
    std::snprintf(line, sizeof line, "m%d %.6f/%.6f ", i - 18, std::sqrt(inverse(i, i)),
                  std::sqrt(found.covariance(i, i)));
    text += line;
  }
  options.progress(text);
}

}  // namespace

Result<SelfCalibration> self_calibrate(const FrameSource& source, const SelfCalibrationOptions& options) {
  const Result<PooledPairs> pooled = pool_pairs(source, options.pairs);
  if (!pooled) {
    return Unexpected(pooled.error());
  }
  const Result<RoughRig> rough =
      rough_rig(pooled->pairs, pooled->size, options.baseline_m, 0.8 * pooled->size.width_px);
  options.progress("pairs " + std::to_string(pooled->pairs.size()) + " inliers " +
                   std::to_string(rough->inliers.size()) + " rms " + std::to_string(rough->rms_px) + " " +
                   describe(rough->rig));
  SelfCalibration found;
  found.rig = rough->rig;
  for (int pass = 0; pass < 2; ++pass) {
    const ViewWarp warp(found.rig);
    const StereoSearch search = search_range(warp, rough->inliers, pass == 0 ? 4 : 2);
    options.progress("search " + std::to_string(search.least_disparity_px) + " " +
                     std::to_string(search.most_disparity_px));
    const Result<std::vector<TrackWindow>> tracks = find_tracks(source, warp, search, pass == 0 ? (options.windows + 1) / 2 : options.windows, options);
    if (!tracks) {
      return Unexpected(tracks.error());
    }
    found.windows = start_windows(found.rig, *tracks);
    std::size_t count = 0;
    for (const BundleWindow& window : found.windows) {
      count += window.points.size();
    }
    options.progress("windows " + std::to_string(found.windows.size()) + " tracks " + std::to_string(count));
    const Result<double> sigma_px = adjust_in_rounds(found.rig, found.windows, options, pass == 0);
    if (!sigma_px) {
      return Unexpected(sigma_px.error());
    }
    found.sigma_px = *sigma_px;
  }
  add_covariance(found, options);
  found.calibration = to_calibration(found.rig);
  return found;
}

}  // namespace kinetrace::self_calibration
