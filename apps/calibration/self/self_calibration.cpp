#include "self_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "outlier_rounds.hpp"
#include "point_pairs.hpp"
#include "rough_rig.hpp"
#include "track_finder.hpp"
#include "view_warp.hpp"
#include "window_start.hpp"

namespace kinetrace::self_calibration {
namespace {

constexpr std::size_t kMinFrames = 9;

cv::Mat to_opencv(GrayView image) {
  return cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                 static_cast<std::size_t>(image.stride));
}

struct PooledPairs {
  ImageSize size;
  std::vector<PointPair> pairs;
};

/// Pairs of frames spread over the recording; damaged frames are skipped.
Result<PooledPairs> pool_pairs(const FrameSource& source, const SelfCalibrationOptions& options) {
  constexpr std::size_t kMinPairs = 150;
  const std::size_t count = std::min(options.pairs, source.frames);
  PooledPairs pooled;
  for (std::size_t i = 0; i < count; ++i) {
    if (const Result<StereoFrame> frame = source.read((2 * i + 1) * source.frames / (2 * count))) {
      pooled.size = {frame->left.width, frame->left.height};
      const std::vector<PointPair> pairs = find_point_pairs(to_opencv(frame->left), to_opencv(frame->right));
      pooled.pairs.insert(pooled.pairs.end(), pairs.begin(), pairs.end());
    }
  }
  if (pooled.pairs.size() < kMinPairs) {
    return fail(ErrorCode::kBadCalibration,
                "self-calibration refused: too few matches between left and right images (" +
                    std::to_string(pooled.pairs.size()) + " in " + std::to_string(count) +
                    " frames); record something with texture that both cameras see, in good light");
  }
  return pooled;
}

/// Range of the first matches, with a margin on both sides.
StereoSearch search_range(const ViewWarp& warp, const std::vector<PointPair>& inliers, int rows_px) {
  std::vector<double> disparities;
  disparities.reserve(inliers.size());
  for (const PointPair& pair : inliers) {
    disparities.push_back((warp.to_warped(0, pair.left_px) - warp.to_warped(1, pair.right_px)).x());
  }
  std::sort(disparities.begin(), disparities.end());
  const std::size_t few = disparities.size() / 100;
  const double least = disparities[few];
  const double most = disparities[disparities.size() - 1 - few];
  return {least - 6.0 - 0.1 * (most - least), most + 10.0 + 0.3 * (most - least), rows_px};
}

/// At least three windows, to estimate their scatter.
std::vector<TrackWindow> find_tracks(const FrameSource& source, const ViewWarp& warp, const StereoSearch& search,
                                     const SelfCalibrationOptions& options, std::size_t most) {
  const std::size_t length = std::min(options.frames_per_window, source.frames / 3);
  const std::size_t count = std::min(std::max<std::size_t>(most, 3), source.frames / length);
  std::vector<TrackWindow> windows;
  for (std::size_t w = 0; w < count; ++w) {
    const std::size_t first = w * (source.frames - length) / (count - 1);
    TrackFinder finder(warp, search);
    for (std::size_t place = first; place < first + length; ++place) {
      if (const Result<StereoFrame> frame = source.read(place)) {
        finder.add(*frame, place);
      }
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

struct Adjusted {
  RigModel rig;
  std::vector<BundleWindow> windows;
  BundleOptions options;  ///< With the scatter of the observations.
};

/// Tracks found by one rig, and the rig that fits them best.
Result<Adjusted> adjusted(const FrameSource& source, const RigModel& rig, const std::vector<PointPair>& inliers,
                          RoundPlan plan, const SelfCalibrationOptions& options) {
  const bool is_near = plan == RoundPlan::kFromNear;
  const ViewWarp warp(rig);
  const StereoSearch search = search_range(warp, inliers, is_near ? 2 : 4);
  const std::size_t count = is_near ? options.windows : (options.windows + 1) / 2;
  const std::vector<TrackWindow> tracks = find_tracks(source, warp, search, options, count);
  Adjusted result{rig, start_windows(rig, tracks), {}};
  result.options.priors = options.priors;
  result.options.threads = options.threads;
  result.options.sigma_px = 0.5;
  if (const Status done = adjust_in_rounds(result.rig, result.windows, plan, result.options); !done) {
    return Unexpected(done.error());
  }
  return result;
}

/// Epipolar geometry does not determine the focal length: tries a usual, a wide and a long lens; takes the first that
/// fits well, else the best.
Result<Adjusted> first_rig(const FrameSource& source, const PooledPairs& pooled, std::vector<PointPair>& inliers,
                           const SelfCalibrationOptions& options) {
  constexpr std::array<double, 3> kFocalLengths{0.8, 0.45, 1.5};  // In image widths.
  constexpr double kGoodFit_px = 0.25;
  constexpr double kGoodShare = 0.5;
  std::optional<Adjusted> best;
  double best_fit = 0.0;
  for (const double focal : kFocalLengths) {
    RoughRig rough = rough_rig(pooled.pairs, pooled.size, options.baseline_m, focal * pooled.size.width_px);
    if (2 * rough.inliers.size() < pooled.pairs.size()) {
      continue;
    }
    Result<Adjusted> result = adjusted(source, rough.rig, rough.inliers, RoundPlan::kFromAfar, options);
    if (!result) {
      return result;
    }
    const double share = used_share(result->windows);
    const double fit = share / result->options.sigma_px;
    if (!best || fit > best_fit) {
      inliers = std::move(rough.inliers);
      best = std::move(*result);
      best_fit = fit;
    }
    if (share > kGoodShare && best->options.sigma_px < kGoodFit_px) {
      break;
    }
  }
  if (!best) {
    return fail(ErrorCode::kBadCalibration,
                "self-calibration refused: left and right images do not fit together as those of a rig; are they "
                "synchronous, side by side, and not exchanged?");
  }
  return std::move(*best);
}

Findings findings_of(const Adjusted& final_fit, const RigCovariance& covariance) {
  constexpr double kFar = 50.0;  // Baselines.
  Findings findings;
  findings.windows = final_fit.windows.size();
  findings.used_share = used_share(final_fit.windows);
  findings.sigma_px = final_fit.options.sigma_px;
  findings.scene = scene_evidence(final_fit.rig, final_fit.windows);
  findings.focal_sigma = focal_sigma(covariance);
  findings.depth_sigma = depth_sigma(final_fit.rig, covariance, kFar * final_fit.rig.baseline_m);
  return findings;
}

Status check(const FrameSource& source, const SelfCalibrationOptions& options) {
  if (!(options.baseline_m > 0.0 && options.baseline_m <= 10.0)) {
    return fail(ErrorCode::kInvalidArgument,
                "the baseline must be above 0 and at most 10 metres, got " + std::to_string(options.baseline_m));
  }
  if (source.frames < kMinFrames) {
    return fail(ErrorCode::kBadCalibration, "self-calibration refused: the recording has " +
                                                std::to_string(source.frames) + " frames; at least " +
                                                std::to_string(kMinFrames) + ", better a hundred, are needed");
  }
  return {};
}

}  // namespace

Result<SelfCalibration> self_calibrate(const FrameSource& source, const SelfCalibrationOptions& options) {
  if (const Status valid = check(source, options); !valid) {
    return Unexpected(valid.error());
  }
  options.progress("matching left and right images");
  const Result<PooledPairs> pooled = pool_pairs(source, options);
  if (!pooled) {
    return Unexpected(pooled.error());
  }
  options.progress("following points, first rig");
  std::vector<PointPair> inliers;
  const Result<Adjusted> first = first_rig(source, *pooled, inliers, options);
  if (!first) {
    return Unexpected(first.error());
  }
  options.progress("following points, final rig");
  const Result<Adjusted> fit = adjusted(source, first->rig, inliers, RoundPlan::kFromNear, options);
  if (!fit) {
    return Unexpected(fit.error());
  }
  SelfCalibration result{to_calibration(fit->rig), fit->rig, rig_covariance(fit->rig, fit->windows, fit->options), {}};
  result.findings = findings_of(*fit, result.covariance);
  if (const Status accepted = verdict(result.findings); !accepted) {
    return Unexpected(accepted.error());
  }
  if (const Status valid = result.calibration.validate(); !valid) {
    return Unexpected(valid.error());
  }
  return result;
}

}  // namespace kinetrace::self_calibration
