#include "background_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <unordered_set>
#include <utility>

#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/features/affine_template.hpp"

namespace kinetrace::batch {
namespace {

using features::AffineGate;
using features::AffinePlace;
using features::AffineTemplate;
using recording::Observation;

/// The run has located each point to a fraction of a pixel; matches farther off are wrong.
constexpr AffineGate kGate{.reach_px = 1.0, .correlation = 0.9};
constexpr double kMaxRowDifference_px = 1.0;
constexpr double kPatchSigma_px = 3.0;

struct Point {
  std::uint32_t id = 0;
  AffineTemplate patch;  ///< From its first left image.
  AffinePlace left;
  std::optional<AffinePlace> right;
  Eigen::Vector2d off_px = Eigen::Vector2d::Zero();  ///< Of the left observation, relative to the run's.
};

class Measurement {
 public:
  Measurement(const recording::Run& run, std::uint32_t next_id)
      : geometry_(run.rectified),
        applied_(run.applied),
        corrected_(run.rectified, RigCorrection{}, run.applied),
        next_id_(next_id) {}

  /// `background`: the run's observations in the frame. The result has the same order.
  std::vector<Observation> measure(const RectifiedPair& pair, std::span<const Observation> background) {
    std::unordered_map<std::uint32_t, Point> points;
    std::vector<Observation> measured;
    measured.reserve(background.size());
    for (const Observation& each : background) {
      std::optional<Point> point = find(pair, each);
      measured.push_back(point ? observe(pair, each, *point) : each);
      if (point) {
        points.emplace(each.point_id, std::move(*point));
      }
    }
    points_ = std::move(points);
    return measured;
  }

  /// The next frame does not follow the previous one.
  void interrupt() { points_.clear(); }
  [[nodiscard]] std::map<std::uint32_t, std::uint32_t> take_parts() { return std::move(part_of_); }

 private:
  /// The point in the left image; after a change of appearance it starts with a new template. Empty where there is no
  /// texture to align.
  std::optional<Point> find(const RectifiedPair& pair, const Observation& seen) {
    const Eigen::Vector2d seen_px(seen.u_left_px, seen.v_px);
    const auto known = points_.find(seen.point_id);
    if (known != points_.end()) {
      Point& point = known->second;
      const auto left = point.patch.align(pair.left, {seen_px + point.off_px, point.left.shape}, kGate);
      if (left) {
        point.left = *left;
        point.off_px = left->position - seen_px;
        return std::move(point);
      }
    }
    const std::optional<AffineTemplate> patch = AffineTemplate::make(pair.left, seen_px, kPatchSigma_px);
    if (!patch) {
      return std::nullopt;
    }
    return Point{name(seen.point_id), *patch, {seen_px}, std::nullopt};
  }

  /// The run's id the first time, a new one afterwards, while any are left.
  std::uint32_t name(std::uint32_t point_id) {
    if (named_.insert(point_id).second || next_id_ == 0) {
      return point_id;
    }
    part_of_.emplace(next_id_, point_id);
    return next_id_++;
  }

  Observation observe(const RectifiedPair& pair, const Observation& seen, Point& point) const {
    Observation measured = seen;
    measured.point_id = point.id;
    measured.u_left_px = static_cast<float>(point.left.position.x());
    measured.v_px = static_cast<float>(point.left.position.y());
    const std::optional<Eigen::Vector2d> right_px = find_right(pair, seen, point);
    measured.u_right_px = right_px ? static_cast<float>(right_px->x()) : std::numeric_limits<float>::quiet_NaN();
    if (right_px) {
      measured.v_px = static_cast<float>(0.5 * (point.left.position.y() + right_px->y()));
    }
    return measured;
  }

  std::optional<Eigen::Vector2d> find_right(const RectifiedPair& pair, const Observation& seen, Point& point) const {
    if (std::isnan(seen.u_right_px)) {
      return std::nullopt;
    }
    const double disparity_px = double{seen.u_left_px} - double{seen.u_right_px};
    const Eigen::Vector2d raw_px =
        applied_.raw_right_px(geometry_, {double{seen.u_right_px}, point.left.position.y()}, disparity_px);
    const auto right =
        point.patch.align(pair.right, {raw_px, point.right ? point.right->shape : point.left.shape}, kGate);
    if (!right) {
      return std::nullopt;
    }
    const Eigen::Vector2d right_px = corrected_.right_px(right->position, disparity_px);
    if (std::abs(right_px.y() - point.left.position.y()) > kMaxRowDifference_px) {
      return std::nullopt;
    }
    point.right = right;
    return right_px;
  }

  StereoGeometry geometry_;
  RigCorrection applied_;
  RigChange corrected_;
  std::uint32_t next_id_;
  std::unordered_set<std::uint32_t> named_;
  std::map<std::uint32_t, std::uint32_t> part_of_;
  std::unordered_map<std::uint32_t, Point> points_;  ///< Visible points, by the run's ids.
};

std::vector<Observation> background_of(std::span<const Observation> seen) {
  std::vector<Observation> background;
  std::copy_if(seen.begin(), seen.end(), std::back_inserter(background),
               [](const Observation& each) { return each.track_id == 0; });
  return background;
}

/// The first id above all of the background's points; 0 if none is left. Reads all observations.
Result<std::uint32_t> first_free_id(const recording::Run& run) {
  Result<recording::ObservationReader> reader = recording::ObservationReader::open(run);
  if (!reader) {
    return Unexpected(reader.error());
  }
  std::uint32_t largest = 0;
  while (true) {
    const Result<std::span<const Observation>> seen = reader->next_frame();
    if (!seen) {
      return Unexpected(seen.error());
    }
    if (seen->empty()) {
      return largest + 1;
    }
    for (const Observation& each : *seen) {
      largest = each.track_id == 0 ? std::max(largest, each.point_id) : largest;
    }
  }
}

}  // namespace

Result<MeasuredBackground> measure_background(const recording::Run& run, const PairReader& read,
                                              const MeasurementOptions& options) {
  const Result<std::uint32_t> free = first_free_id(run);
  if (!free) {
    return Unexpected(free.error());
  }
  Result<recording::ObservationReader> reader = recording::ObservationReader::open(run);
  if (!reader) {
    return Unexpected(reader.error());
  }
  Measurement measurement(run, *free);
  MeasuredBackground measured;
  while (options.keep_going()) {
    const Result<std::span<const Observation>> seen = reader->next_frame();
    if (!seen) {
      return Unexpected(seen.error());
    }
    if (seen->empty()) {
      break;
    }
    const std::int64_t frame = seen->front().frame;
    if (const Result<RectifiedPair> pair = read(frame)) {
      const std::vector<Observation> before = background_of(*seen);
      std::vector<Observation> now = measurement.measure(*pair, before);
      measured.changes.emplace(frame, DisparityChange::between(run.rectified, before, now));
      measured.frames.emplace(frame, std::move(now));
    } else {
      measurement.interrupt();
      ++measured.frames_without_images;
    }
    options.progress(measured.frames.size());
  }
  measured.part_of = measurement.take_parts();
  return measured;
}

}  // namespace kinetrace::batch
