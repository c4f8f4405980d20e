#include "kinetrace/rig/rig_refiner.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <numbers>
#include <string>

#include "kinetrace/core/quantiles.hpp"
#include "rig_filter.hpp"
#include "two_view_calibration.hpp"

namespace kinetrace::rig {

/// A feature as captured.
struct SeenPoint {
  std::uint32_t id = 0;
  Eigen::Vector2f left_px{0.F, 0.F};
  Eigen::Vector2f right_px{0.F, 0.F};
};

// Below this turn an error of one percent of the focal length moves no feature by more than .2 px, the residual
// distortion of real lenses.
constexpr double kMinTurn_rad = 0.05;

/// Turns of the camera about x and y over the windows: these make a focal length observable.
struct SeenTurns {
  double sum_rad = 0.0;
  double sum_rad2 = 0.0;

  void add(double turn_rad) noexcept {
    sum_rad += turn_rad;
    sum_rad2 += turn_rad * turn_rad;
  }
  /// Typical turn of a window, in which large turns weigh more, like their information. 0: none so far.
  [[nodiscard]] double typical_rad() const noexcept { return sum_rad > 0.0 ? sum_rad2 / sum_rad : 0.0; }
};

/// All larger state, in the arena.
struct RigRefinerStorage {
  RigFilter filter;
  SeenTurns turns;
  std::span<SeenPoint> reference;  ///< By slot: features of the window's first frame; id 0 means none.
  std::size_t reference_count = 0;
  Se3 T_world_reference;
  std::int64_t reference_ns = 0;
  std::int64_t filtered_ns = 0;  ///< Time of the filter's state.
  std::int64_t now_ns = 0;
  bool begun = false;
  std::bitset<RigCorrection::kSize> off;  ///< States found to be off.
  std::span<TwoViewPoint> points;
  std::span<float> depths_m;
};

namespace {

constexpr std::size_t kMinPoints = 24;  // Five rows each, for twenty unknowns.
// A window ends when the camera has moved by the first fraction of the scene's depth. A window that has to end earlier
// needs the second.
constexpr double kParallax = 0.06;
constexpr double kMinParallax = 0.015;
// ... or when half of its points are gone, or after the maximum time.
constexpr double kMinShared = 0.5;
constexpr double kMaxWindow_s = 2.0;
constexpr double kMinWindow_s = 0.15;
// A steady, well-known rig is measured less often.
constexpr double kRelaxed_s = 0.9;
constexpr std::uint64_t kRelaxedAfter = 8;
// The certain part of a state is its estimate times max(0, 1 - (kShrinkSigmas sigma / estimate)^2).
constexpr double kShrinkSigmas = 2.0;
// A state is off beyond this many.
constexpr double kOff = 4.0;
// Residual lens distortion: in KITTI's recordings, with about .2 px of it, windows scatter six times as much as noise
// explains.
constexpr double kDistortionPerScatter_px = 0.08;
constexpr double kDistortionInMean = 0.3;
constexpr double kUsualDisparity_px = 20.0;
// There, distortion resembles a focal error of .003 over the turn in radians: ten times .2 px over the focal length.
constexpr double kFocalPerDistortion = 10.0;
// A single pair of frames may be wrong.
constexpr std::uint64_t kMinWindows = 2;
// Below the first a change moves no feature; above the second, the window of bundle adjustment would mix two
// geometries.
constexpr double kSmallChange_px = 0.015;
constexpr double kLargeChange_px = 0.7;
// Errors below this do not matter.
constexpr double kNoticeable_px = 0.1;
constexpr double kNoticeableFocal = 0.002;  // Two tenths of a percent of any depth.
// With a larger sigma the verdict is unknown.
constexpr double kMaxSigma_px = 0.15;

double seconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

/// Largest distance between two corrections in the image, at its middle and in its corners.
double distance_px(const StereoGeometry& g, const RigCorrection& a, const RigCorrection& b) {
  constexpr double kNearDisparity = 0.06;  // Fraction of the focal length.
  double most = 0.0;
  for (const double u : {0.0, 0.5, 1.0}) {
    for (const double v : {0.0, 1.0}) {
      const Eigen::Vector2d pixel(u * g.width_px, v * g.height_px);
      const double disparity_px = kNearDisparity * g.fx_px;
      most = std::max(most, (a.raw_right_px(g, pixel, disparity_px) - b.raw_right_px(g, pixel, disparity_px)).norm());
    }
  }
  return most;
}

/// Residual distortion, px, from excess scatter: distortion fits no rotation of the camera and biases the estimate.
double distortion_px(double scatter) {
  return kDistortionPerScatter_px * std::sqrt(scatter - 1.0);
}

/// In a turn, a focal error causes flow that grows with the square of the column. So do errors of the disparities over
/// the image, independent of the turn: the smaller the turn, the larger the resulting focal error.
double focal_error(const RefineConfig& config, double focal_px, double scatter, double turn_rad) {
  return kFocalPerDistortion * (config.bias_px + distortion_px(scatter)) / (focal_px * turn_rad);
}

/// Errors that do not average out over windows.
RigCorrection::Vector lasting_error_rad(const RefineConfig& config, const StereoGeometry& geometry, double scatter,
                                        double turn_rad) {
  const double focal_px = geometry.fx_px;
  const double residual_px = distortion_px(scatter);
  // Turns about x and y follow from the mean over the image, the roll from half its size, the baseline from
  // disparities.
  const double mean_rad = (config.bias_px + kDistortionInMean * residual_px) / focal_px;
  const double edge_rad = (config.bias_px + residual_px) / (0.5 * focal_px);
  const double disparity_rad = (0.1 * config.bias_px + residual_px) / kUsualDisparity_px;
  RigCorrection::Vector error;
  // A shift and a turn about y differ only by a term of the square of the column, as lens distortion causes, too.
  const double shift_rad = 2.0 * mean_rad + residual_px / (0.15 * focal_px);
  constexpr double kNothingKnown = 1.0;
  const double focal = turn_rad > 0.0 ? focal_error(config, focal_px, scatter, turn_rad) : kNothingKnown;
  error << mean_rad, mean_rad, edge_rad, disparity_rad, 2.0 * disparity_rad, shift_rad, focal;
  return error;
}

/// The principal point moves less than the mount turns.
RigCorrection::Vector prior_sigma_rad(const RefineConfig& config) {
  constexpr double kShift = 0.01;
  constexpr double kFocal = 0.01;
  const double turn_rad = config.prior_sigma_deg * std::numbers::pi / 180.0;
  RigCorrection::Vector sigma = RigCorrection::Vector::Constant(turn_rad);
  sigma[RigCorrection::kShift] = kShift * turn_rad;
  sigma[RigCorrection::kFocal] = kFocal;
  return sigma;
}

using Flags = std::bitset<RigCorrection::kSize>;

/// The certain part of the estimate. States of largest uncertainty come first; the others are conditioned on their
/// shrunk values. A state once found to be off is used as estimated: the calibration says nothing about it any more.
/// `found`, if not null, gains the states that are off, given the shrunk values of those before.
RigCorrection::Vector shrunk_estimate(RigCorrection::Vector value, RigCorrection::Matrix covariance,
                                      const RigCorrection::Vector& lasting_rad, const Flags& off,
                                      Flags* found = nullptr) {
  constexpr std::array<int, RigCorrection::kSize> kOrder{RigCorrection::kFocal, RigCorrection::kShift, 4, 3, 2, 0, 1};
  for (const int i : kOrder) {
    const double variance = covariance(i, i) + lasting_rad[i] * lasting_rad[i];
    if (found != nullptr && std::abs(value[i]) > kOff * std::sqrt(variance)) {
      found->set(static_cast<std::size_t>(i));
    }
    const double kept =
        off[static_cast<std::size_t>(i)]
            ? 1.0
            : std::max(0.0, 1.0 - kShrinkSigmas * kShrinkSigmas * variance / std::max(value[i] * value[i], 1e-30));
    const RigCorrection::Vector gain = covariance.col(i) / covariance(i, i);
    value -= gain * ((1.0 - kept) * value[i]);
    covariance -= gain * covariance.row(i).eval();
    // Fixed: later states do not change it.
    covariance.row(i).setZero();
    covariance.col(i).setZero();
    covariance(i, i) = 1e-30;
  }
  return value;
}

}  // namespace

std::size_t RigRefiner::required_bytes(const RefineConfig& config) {
  if (config.mode == RefineMode::kOff) {
    return 0;
  }
  return measure_bytes([&](Arena& arena) {
    static_cast<void>(arena.take<RigRefinerStorage>(1));
    static_cast<void>(arena.take<SeenPoint>(static_cast<std::size_t>(config.max_features)));
    static_cast<void>(arena.take<TwoViewPoint>(static_cast<std::size_t>(config.max_features)));
    static_cast<void>(arena.take<float>(static_cast<std::size_t>(config.max_features)));
  });
}

Result<RigRefiner> RigRefiner::create(const RefineConfig& config, const StereoGeometry& geometry, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  const auto features = static_cast<std::size_t>(config.max_features);
  const std::span<RigRefinerStorage> home = arena.take<RigRefinerStorage>(1);
  const std::span<SeenPoint> reference = arena.take<SeenPoint>(features);
  const std::span<TwoViewPoint> points = arena.take<TwoViewPoint>(features);
  const std::span<float> depths = arena.take<float>(features);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the " + std::to_string(required_bytes(config)) +
                                          " bytes that refining the calibration needs; raise the memory budget or set "
                                          "calibration.refine: off");
  }
  home[0].filter = RigFilter(prior_sigma_rad(config));
  home[0].reference = reference;
  home[0].points = points;
  home[0].depths_m = depths;
  return RigRefiner(config, geometry, home[0]);
}

RigRefiner::RigRefiner(const RefineConfig& config, const StereoGeometry& geometry, RigRefinerStorage& storage)
    : config_(config), geometry_(geometry), storage_(&storage) {}

void RigRefiner::begin_frame(std::int64_t timestamp_ns) {
  RigRefinerStorage& s = *storage_;
  s.now_ns = timestamp_ns;
  if (!s.begun) {
    s.filtered_ns = timestamp_ns;
    s.begun = true;
  }
  before_revision_ = estimate_.applied;
  revision_ = pending_;
  pending_.reset();
  if (revision_) {
    estimate_.applied = *revision_;
  }
  s.filter.predict(seconds(timestamp_ns - s.filtered_ns));
  s.filtered_ns = timestamp_ns;
  publish();
  if (config_.mode != RefineMode::kOn) {
    return;
  }
  // Also follows the predicted motion of the rig itself.
  const RigCorrection target = to_apply();
  if (distance_px(geometry_, target, estimate_.applied) > kSmallChange_px) {
    estimate_.applied = target;
  }
}

RigCorrection RigRefiner::shrunk_correction() const {
  const RigFilter& filter = storage_->filter;
  return RigCorrection::from(shrunk_estimate(
      filter.correction(), filter.covariance(),
      lasting_error_rad(config_, geometry_, filter.scatter(), storage_->turns.typical_rad()), storage_->off));
}

RigCorrection RigRefiner::to_apply() const {
  RigCorrection target = shrunk_correction();
  target.focal = 0.0;
  return target;
}

void RigRefiner::revise() {
  const RigCorrection target = to_apply();
  if (config_.mode == RefineMode::kOn && distance_px(geometry_, target, estimate_.applied) > kSmallChange_px) {
    pending_ = target;
  }
}

bool RigRefiner::must_restart() const {
  return revision_ && distance_px(geometry_, *revision_, before_revision_) > kLargeChange_px;
}

void RigRefiner::forget_scene() noexcept {
  storage_->reference_count = 0;
}

Eigen::Vector2f RigRefiner::raw_right(const RigObservation& o) const {
  const double disparity_px = static_cast<double>(o.left_px.x() - o.right_px.x());
  return estimate_.applied.raw_right_px(geometry_, o.right_px.cast<double>(), disparity_px).cast<float>();
}

void RigRefiner::begin_window(std::span<const RigObservation> observations, const Se3& T_world_cam) {
  RigRefinerStorage& s = *storage_;
  std::fill(s.reference.begin(), s.reference.end(), SeenPoint{});
  for (const RigObservation& o : observations) {
    s.reference[o.slot] = {o.id, o.left_px, raw_right(o)};
  }
  s.reference_count = observations.size();
  s.T_world_reference = T_world_cam;
  s.reference_ns = s.now_ns;
}

RigRefiner::Parallax RigRefiner::parallax_of(std::span<const RigObservation> observations, const Se3& T_world_cam) {
  RigRefinerStorage& s = *storage_;
  Parallax parallax;
  for (const RigObservation& o : observations) {
    if (s.reference[o.slot].id == o.id) {
      constexpr double kMinDisparity_px = 1.0;
      const double disparity_px = static_cast<double>(o.left_px.x() - o.right_px.x());
      s.depths_m[parallax.shared++] = static_cast<float>(geometry_.depth_m(std::max(kMinDisparity_px, disparity_px)));
    }
  }
  if (parallax.shared >= kMinPoints) {
    const float depth_m = median(s.depths_m.first(parallax.shared));
    parallax.moved = (T_world_cam.translation - s.T_world_reference.translation).norm() / double{depth_m};
  }
  return parallax;
}

bool RigRefiner::window_ends(const Parallax& parallax, double window_s) const {
  const RigRefinerStorage& s = *storage_;
  const bool has_to = window_s >= kMaxWindow_s ||
                      static_cast<double>(parallax.shared) < kMinShared * static_cast<double>(s.reference_count);
  const bool relaxed = s.filter.holds_still() && s.filter.updates() >= kRelaxedAfter;
  return has_to || (parallax.moved >= kParallax && (!relaxed || window_s >= kRelaxed_s));
}

// Selects shared points evenly over the slots, whose order is independent of image position.
std::size_t RigRefiner::pair_points(std::span<const RigObservation> observations, std::size_t shared) {
  RigRefinerStorage& s = *storage_;
  const std::size_t wanted = std::min(shared, static_cast<std::size_t>(config_.max_points));
  std::size_t count = 0;
  std::size_t seen = 0;
  for (const RigObservation& o : observations) {
    const SeenPoint& before = s.reference[o.slot];
    if (before.id == o.id && ++seen * wanted / shared > count) {
      s.points[count++] = {before.left_px, before.right_px, o.left_px, raw_right(o)};
    }
  }
  return count;
}

void RigRefiner::observe(std::span<const RigObservation> observations, const Se3& T_world_cam) {
  RigRefinerStorage& s = *storage_;
  const double window_s = seconds(s.now_ns - s.reference_ns);
  if (s.reference_count >= kMinPoints) {
    if (window_s < kMinWindow_s) {
      return;
    }
    const Parallax parallax = parallax_of(observations, T_world_cam);
    if (parallax.shared >= kMinPoints && !window_ends(parallax, window_s)) {
      return;
    }
    if (parallax.shared >= kMinPoints && parallax.moved >= kMinParallax) {
      const std::size_t count = pair_points(observations, parallax.shared);
      measure(s.points.first(count), T_world_cam.inverse() * s.T_world_reference, window_s);
    }
  }
  begin_window(observations, T_world_cam);
}

void RigRefiner::measure(std::span<const TwoViewPoint> points, const Se3& T_now_before, double window_s) {
  RigRefinerStorage& s = *storage_;
  const double turn_rad = so3_log(T_now_before.rotation).head<2>().norm();
  const bool focal_shown = turn_rad >= kMinTurn_rad;
  RigMeasurement measured =
      calibrate_two_views(geometry_, points, T_now_before, s.filter.expected(window_s), focal_shown);
  if (measured.valid && measured.points >= static_cast<int>(kMinPoints) / 2) {
    if (focal_shown) {
      add_focal_error(turn_rad, measured);
    }
    s.filter.update(measured, window_s);
    publish();
    revise();
  }
}

void RigRefiner::add_focal_error(double turn_rad, RigMeasurement& measured) {
  storage_->turns.add(turn_rad);
  // The conditional covariance of the others, given the focal length, stays.
  constexpr int kFocal = RigCorrection::kFocal;
  const RigMeasurement::Vector along = measured.covariance.col(kFocal) / measured.covariance(kFocal, kFocal);
  const double error = focal_error(config_, geometry_.fx_px, storage_->filter.scatter(), turn_rad);
  measured.covariance += error * error * along * along.transpose();
}

void RigRefiner::publish() {
  const RigFilter& filter = storage_->filter;
  const RigCorrection::Vector lasting_rad =
      lasting_error_rad(config_, geometry_, filter.scatter(), storage_->turns.typical_rad());
  const RigCorrection::Vector value = filter.correction();
  estimate_.correction = RigCorrection::from(value);
  estimate_.sigma_rad = (filter.covariance().diagonal().array() + lasting_rad.array().square()).sqrt();
  if (filter.updates() >= kMinWindows) {
    Flags found = storage_->off;
    static_cast<void>(shrunk_estimate(value, filter.covariance(), lasting_rad, storage_->off, &found));
    storage_->off = found;
  }
  // At the image's middle a turn about y and a shift are the same.
  RigCorrection::Vector both = RigCorrection::Vector::Zero();
  both[1] = both[RigCorrection::kShift] = 1.0;
  estimate_.disparity_sigma_rad = std::sqrt(both.dot(filter.covariance() * both) + lasting_rad[1] * lasting_rad[1]);
  estimate_.windows = filter.updates();
  estimate_.knocks = filter.knocks();
  const double yaw_sigma_px = estimate_.disparity_sigma_rad * geometry_.fx_px;
  const RigCorrection known = shrunk_correction();
  estimate_.known_focal = known.focal;
  const bool is_turned = distance_px(geometry_, known, {}) > kNoticeable_px;
  const bool is_off = is_turned || std::abs(known.focal) > kNoticeableFocal;
  if (estimate_.windows == 0 || (!is_off && yaw_sigma_px > kMaxSigma_px)) {
    estimate_.verdict = RigVerdict::kUnknown;
  } else if (!is_off) {
    estimate_.verdict = RigVerdict::kHolds;
  } else {
    estimate_.verdict = is_turned && config_.mode == RefineMode::kOn ? RigVerdict::kCorrected : RigVerdict::kOff;
  }
}

}  // namespace kinetrace::rig
