#include "object_recogniser.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "translation_consensus.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kRememberedPoints = 64;
constexpr std::size_t kMinRecognised = 4;
constexpr std::size_t kMinAgreeing = 8;  // Four or five may agree on a pose by chance.
constexpr std::int64_t kMemoryInterval_ns = 300'000'000;
// First pass: displacement of points half a metre from the centre by a rotation of some degrees, and noise of stereo.
constexpr double kCoarseRadius_m = 0.15;
constexpr float kCoarseMinSimilarity = 0.85F;
// Refinement: a pose that some points agree on predicts the others, so that less similarity suffices.
constexpr double kFineReach_m = 0.15;
constexpr double kFineRadius_m = 0.06;
constexpr float kFineMinSimilarity = 0.75F;
constexpr int kRefinements = 2;
constexpr double kDisparitySigma_px = 0.2;
constexpr double kMinDepth_m = 0.5;
constexpr double kPointSigma_m = 0.02;  // Of a remembered point on its object.
constexpr double kMaxSigmas = 3.0;      // Farther from the prior a match is a similar point of another object.
constexpr float kOutsideImage_px = -1e6F;

/// Displacement of a remembered point to where it is found, object frame.
Eigen::Vector3d displacement_of(const features::RecognisedPoint& point, const Se3& T_obj_cam,
                                const StereoGeometry& geometry) {
  const auto u = double{point.left_px.x()};
  return T_obj_cam * geometry.triangulate(u, double{point.v_px}, u - double{point.u_right_px}) -
         point.p_body.cast<double>();
}

/// Weight of a shift in depth against a lateral one: stereo noise may exceed the consensus radius.
double depth_weight(double depth_m, double radius_m, const StereoGeometry& geometry) {
  const double sigma_m = geometry.depth_sigma_m(depth_m, kDisparitySigma_px);
  return radius_m / std::hypot(radius_m, 2.0 * sigma_m);
}

sfm::PoseObservation observation_of(const features::RecognisedPoint& point, const StereoGeometry& geometry) {
  const double point_sigma_px = kPointSigma_m / geometry.baseline_m * double{point.left_px.x() - point.u_right_px};
  return {point.p_body.cast<double>(), point.left_px.x(), point.v_px, point.u_right_px,
          static_cast<float>(1.0 + point_sigma_px * point_sigma_px)};
}

sfm::BodyReconstruction::Expectation expectation_of(const PosePrior& prior) {
  sfm::BodyReconstruction::Expectation expected{prior.T_obj_cam};
  expected.covariance.topLeftCorner<3, 3>().diagonal().setConstant(prior.rotation_sigma_rad * prior.rotation_sigma_rad);
  expected.covariance.bottomRightCorner<3, 3>().diagonal().setConstant(prior.position_sigma_m * prior.position_sigma_m);
  return expected;
}

}  // namespace

ObjectRecogniser::ObjectRecogniser(const StereoGeometry& geometry, Arena& arena)
    : geometry_(geometry), memory_(kRememberedPoints, arena) {}

void ObjectRecogniser::clear() noexcept {
  memory_.clear();
  since_memory_.reset();
}

void ObjectRecogniser::swap(ObjectRecogniser& other) noexcept {
  memory_.swap(other.memory_);
  std::swap(since_memory_, other.since_memory_);
}

bool ObjectRecogniser::has_enough_points() const noexcept {
  return memory_.size() >= kMinRecognised;
}

void ObjectRecogniser::remember(const sfm::BodyReconstruction& body, const FeatureFrame& frame, std::uint8_t label,
                                const features::FeatureFrontEnd& front_end, std::int64_t interval_ns) {
  since_memory_.add_frame(interval_ns);
  if (!since_memory_.exceeds(kMemoryInterval_ns) || body.history_size() < kMinBodyFrames) {
    return;
  }
  std::array<features::KnownPoint, kRememberedPoints> points;
  std::size_t count = 0;
  for (const Feature& feature : frame.features) {
    const Eigen::Vector3d* const p_body =
        feature.body == label && count < points.size() ? body.place_of(feature) : nullptr;
    if (p_body != nullptr) {
      points[count++] = {feature.slot, p_body->cast<float>()};
    }
  }
  if (count >= kMinRecognised) {
    front_end.remember(std::span(points).first(count), memory_);
    since_memory_.reset();
  }
}

std::size_t ObjectRecogniser::find_appearance_matches(const Se3& T_cam_obj, const MatchGate& match_gate,
                                                      std::uint8_t label, const features::FeatureFrontEnd& front_end,
                                                      std::span<features::RecognisedPoint> found) const {
  std::array<features::ExpectedObservation, kRememberedPoints> expected;
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    const Eigen::Vector3d p_cam = T_cam_obj * memory_.p_body(i).cast<double>();
    expected[i] = features::ExpectedObservation(kOutsideImage_px, kOutsideImage_px);
    if (p_cam.z() >= kMinDepth_m) {
      expected[i] = geometry_.project(p_cam).head<2>().cast<float>();
    }
  }
  const double px_per_m = geometry_.fx_px / std::max(T_cam_obj.translation.z(), kMinDepth_m);
  const Eigen::Vector2f reach_px =
      (px_per_m * Eigen::Vector2d(match_gate.reach_m, 0.5 * match_gate.reach_m)).cast<float>();
  return front_end.recognise(memory_, std::span(expected).first(memory_.size()), {reach_px, match_gate.min_similarity},
                             label, found);
}

std::optional<ObjectRecogniser::PoseConsensus> ObjectRecogniser::find_consensus(
    const Se3& T_obj_cam, const MatchGate& match_gate, const PosePrior& prior, sfm::BodyReconstruction& body,
    std::uint8_t label, const features::FeatureFrontEnd& front_end) const {
  const Se3 T_cam_obj = T_obj_cam.inverse();
  std::array<features::RecognisedPoint, TranslationConsensus::kMaxMembers> found;
  const std::size_t count = find_appearance_matches(T_cam_obj, match_gate, label, front_end, found);

  // The object has turned little since, so that all points share one translation, up to stereo's noise in depth.
  const double weight = depth_weight(std::max(T_cam_obj.translation.z(), kMinDepth_m), match_gate.radius_m, geometry_);
  std::array<AppearanceMatch, TranslationConsensus::kMaxMembers> matches;
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector3d shift_cam_m = T_cam_obj.rotation * displacement_of(found[i], T_obj_cam, geometry_);
    shift_cam_m.z() *= weight;
    matches[i] = {found[i].slot, found[i].point, shift_cam_m};
  }
  const TranslationConsensus group =
      largest_group(std::span(matches).first(count), match_gate.reach_m, match_gate.radius_m);
  if (group.count < kMinRecognised) {
    return std::nullopt;
  }
  std::array<sfm::PoseObservation, TranslationConsensus::kMaxMembers> observations;
  for (std::size_t k = 0; k < group.count; ++k) {
    observations[k] = observation_of(found[group.members[k]], geometry_);
  }
  // Far away, depth is less certain than the prior, which then dominates.
  const std::optional<Se3> pose = body.pose_from(std::span(observations).first(group.count), expectation_of(prior),
                                                 static_cast<int>(kMinRecognised));
  const bool turned_too_far = pose && so3_log(pose->rotation * prior.T_obj_cam.rotation.transpose()).norm() >
                                          kMaxSigmas * prior.rotation_sigma_rad;
  return !pose || turned_too_far ? std::nullopt : std::optional<PoseConsensus>({*pose, group.count});
}

std::optional<Se3> ObjectRecogniser::recognise(const PosePrior& prior, sfm::BodyReconstruction& body,
                                               std::uint8_t label, const features::FeatureFrontEnd& front_end) const {
  const MatchGate coarse{kMaxSigmas * prior.position_sigma_m, kCoarseRadius_m, kCoarseMinSimilarity};
  const MatchGate fine{kFineReach_m, kFineRadius_m, kFineMinSimilarity};
  std::optional<PoseConsensus> found = find_consensus(prior.T_obj_cam, coarse, prior, body, label, front_end);
  for (int i = 0; i < kRefinements && found; ++i) {
    found = find_consensus(found->T_obj_cam, fine, prior, body, label, front_end);
  }
  return found && found->points >= kMinAgreeing ? std::optional<Se3>(found->T_obj_cam) : std::nullopt;
}

}  // namespace kinetrace::pipeline
