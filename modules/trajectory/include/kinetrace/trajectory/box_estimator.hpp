// Upright 3-D box of an object from all that shows how large it is and where.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/body.hpp"
#include "kinetrace/core/box3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/trajectory/box_view.hpp"
#include "kinetrace/trajectory/ground_plane.hpp"
#include "kinetrace/trajectory/size_table.hpp"

namespace kinetrace::trajectory {

struct BoxEvidence;
struct BoxFit;

/// What a frame tells about an object's box. The object's frame was parallel to the world's at birth and turns with the
/// object.
struct BoxFrame {
  std::int64_t timestamp_ns = 0;
  std::uint16_t class_id = 0;
  Se3 T_world_obj;
  Se3 T_obj_cam;
  std::optional<MaskEdges> edges;     ///< None: the object has not been seen in this frame.
  std::span<const BodyPoint> points;  ///< Of its reconstruction; without one, its stereo position.
  double disparity_sigma_px = 0.0;    ///< Of these points.
  Ground ground;                      ///< World frame; `down` counts even if the ground is not known.
  bool turns_are_seen = false;        ///< T_world_obj turns as the object does.
  std::optional<Heading> heading;     ///< Of its motion in the world, where it moves.
};

/// Maximum a posteriori estimate of centre, yaw and size, with covariance, by robust Gauss-Newton over a few views of
/// the object. It weighs the mask's edges (Bertoni et al. 2019 use its height, Mousavian et al. 2017 all four), the
/// reconstructed points on the faces that were seen (L-shape fitting; Zhang et al. 2017), the ground, the direction of
/// motion, and what sizes its class usually has, by which it knows of the sides that nobody has seen. Of the frames
/// that show it from about the same side, the best one counts, so that hundreds of alike views are no more sure than
/// one.
class BoxEstimator {
 public:
  BoxEstimator(const SizeTable& sizes, const StereoGeometry& geometry, Arena& arena);
  void reset() noexcept;
  /// Its object's frame has moved: earlier views are void, its size is not.
  void forget_views() noexcept;
  [[nodiscard]] bool known() const noexcept { return known_; }
  void update(const BoxFrame& frame) noexcept;
  [[nodiscard]] Box3 box_in_object() const noexcept {
    return {state_.center_m, state_.size_m, state_.yaw_rad, down_obj_};
  }
  [[nodiscard]] Box3 box_in_world(const Se3& T_world_obj) const noexcept;
  /// Holds what other boxes that are nearly as probable differ by.
  [[nodiscard]] Box3Sigma sigma() const noexcept;

 private:
  void keep_view(const BoxFrame& frame) noexcept;
  /// The one that the mask's height suggests.
  [[nodiscard]] const KindOfObject& likely_kind(const BoxFrame& frame) const noexcept;
  /// A box of that kind turned by `yaw_rad`, behind the middle of the points.
  [[nodiscard]] BoxState start_at(const BoxFrame& frame, double yaw_rad, const KindOfObject& kind) const noexcept;
  void begin(const BoxFrame& frame, const BoxEvidence& evidence) noexcept;
  void challenge(const BoxEvidence& evidence, const BoxState& start, int iterations, double margin) noexcept;
  [[nodiscard]] BoxState challenger(const BoxFrame& frame, const BoxEvidence& evidence) const noexcept;
  /// A box that is less probable by `behind`, twice the difference of log-likelihoods.
  void note_rival(const BoxState& rival, double behind) noexcept;
  void note_heading(const BoxFrame& frame, const Ground& ground_obj) noexcept;
  void take(const BoxFit& fit) noexcept;

  SizeTable sizes_;
  StereoGeometry geometry_;
  std::span<BoxView> views_;  ///< By the side from which they show the object.
  BoxState state_;
  double cost_ = 0.0;
  Box3Sigma sigma_;  ///< Of the most probable box alone.
  Box3Sigma rival_;  ///< Root of what rivals of late differ by, squared, times their probabilities.
  Eigen::Vector3d down_world_ = Eigen::Vector3d::UnitY();
  Eigen::Vector3d down_obj_ = Eigen::Vector3d::UnitY();
  std::optional<Heading> heading_;  ///< Newest one known, object frame.
  std::int64_t timestamp_ns_ = 0;
  std::uint32_t updates_ = 0;
  bool known_ = false;
};

}  // namespace kinetrace::trajectory
