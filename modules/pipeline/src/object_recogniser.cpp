#include "object_recogniser.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kRememberedPoints = 64;
constexpr std::size_t kMaxRecognised = 400;
constexpr int kLeastRecognised = 6;
constexpr int kFramesBetweenNotes = 4;
// How far off a guess may be.
constexpr double kGuessReach_m = 0.8;
constexpr double kGuessTurn_rad = 0.1;
// Points half a metre from the middle move so far by such a turn, and stereo errs as well.
constexpr double kGroupRadius_m = 0.15;
constexpr double kNearest_m = 0.5;
constexpr float kNowhere_px = -1e6F;

/// Points that lie together.
struct Group {
  int members = 0;
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
};

Group largest_group(std::span<const Eigen::Vector3d> points_m) {
  Group largest;
  for (const Eigen::Vector3d& centre_m : points_m) {
    Group group;
    for (const Eigen::Vector3d& point_m : points_m) {
      if ((point_m - centre_m).norm() <= kGroupRadius_m) {
        ++group.members;
        group.middle_m += point_m;
      }
    }
    if (group.members > largest.members) {
      largest = {group.members, group.middle_m / group.members};
    }
  }
  return largest;
}

/// An object's remembered point, and where it is seen again.
Eigen::Vector3d shift_of(const features::RecognisedPoint& point, const Se3& T_obj_cam, const StereoGeometry& geometry) {
  const auto u = double{point.left_px.x()};
  return T_obj_cam * geometry.triangulate(u, double{point.v_px}, u - double{point.u_right_px}) -
         point.p_body.cast<double>();
}

}  // namespace

ObjectRecogniser::ObjectRecogniser(const StereoGeometry& geometry, Arena& arena)
    : geometry_(geometry), memory_(kRememberedPoints, arena) {}

void ObjectRecogniser::clear() noexcept {
  memory_.clear();
  frames_since_note_ = 0;
}

void ObjectRecogniser::swap(ObjectRecogniser& other) noexcept {
  memory_.swap(other.memory_);
  std::swap(frames_since_note_, other.frames_since_note_);
}

bool ObjectRecogniser::knows_it() const noexcept {
  return memory_.size() >= static_cast<std::size_t>(kLeastRecognised);
}

void ObjectRecogniser::remember(const sfm::BodyReconstruction& body, const FeatureFrame& frame, std::uint8_t label,
                                const features::FeatureFrontEnd& front_end) {
  if (++frames_since_note_ < kFramesBetweenNotes || body.history_size() < kSettledBodyFrames) {
    return;
  }
  std::array<features::KnownPoint, kRememberedPoints> points;
  std::size_t count = 0;
  for (const Feature& feature : frame.features) {
    const Eigen::Vector3d* const place =
        feature.body == label && count < points.size() ? body.place_of(feature) : nullptr;
    if (place != nullptr) {
      points[count++] = {feature.slot, place->cast<float>()};
    }
  }
  if (count >= static_cast<std::size_t>(kLeastRecognised)) {
    front_end.remember(std::span(points).first(count), memory_);
    frames_since_note_ = 0;
  }
}

std::optional<Se3> ObjectRecogniser::recognise(const Se3& T_obj_cam_guess, sfm::BodyReconstruction& body,
                                               std::uint8_t label, const features::FeatureFrontEnd& front_end) const {
  const Se3 T_cam_obj = T_obj_cam_guess.inverse();
  std::array<features::ExpectedSighting, kRememberedPoints> expected;
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    const Eigen::Vector3d p_cam = T_cam_obj * memory_.p_body(i).cast<double>();
    expected[i] = features::ExpectedSighting(kNowhere_px, kNowhere_px);
    if (p_cam.z() >= kNearest_m) {
      expected[i] = geometry_.project(p_cam).head<2>().cast<float>();
    }
  }
  const double px_per_m = geometry_.fx_px / std::max(T_cam_obj.translation.z(), kNearest_m);
  const Eigen::Vector2f reach_px = (px_per_m * Eigen::Vector2d(kGuessReach_m, 0.5 * kGuessReach_m)).cast<float>();
  std::array<features::RecognisedPoint, kMaxRecognised> found;
  const std::size_t count =
      front_end.recognise(memory_, std::span(expected).first(memory_.size()), reach_px, label, found);

  // It has turned little while it was away, so all of it has moved alike.
  std::array<Eigen::Vector3d, kMaxRecognised> shift_m;
  for (std::size_t i = 0; i < count; ++i) {
    shift_m[i] = shift_of(found[i], T_obj_cam_guess, geometry_);
  }
  const Group group = largest_group(std::span(shift_m).first(count));
  if (group.members < kLeastRecognised) {
    return std::nullopt;
  }
  std::array<sfm::PoseObservation, kMaxRecognised> observations;
  std::size_t members = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if ((shift_m[i] - group.middle_m).norm() <= kGroupRadius_m) {
      observations[members++] = {found[i].p_body.cast<double>(), found[i].left_px.x(), found[i].v_px,
                                 found[i].u_right_px, 1.F};
    }
  }
  sfm::BodyReconstruction::Expectation guess{{T_obj_cam_guess.rotation, T_obj_cam_guess.translation - group.middle_m}};
  guess.covariance.topLeftCorner<3, 3>().diagonal().setConstant(kGuessTurn_rad * kGuessTurn_rad);
  guess.covariance.bottomRightCorner<3, 3>().diagonal().setConstant(kGuessReach_m * kGuessReach_m);
  return body.pose_from(std::span(observations).first(members), guess, kLeastRecognised);
}

}  // namespace kinetrace::pipeline
