// Upright 3-D box of an object from all evidence of its size and position.
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

/// Evidence of one frame for an object's box. The object's frame was parallel to the world's at first and turns with
/// the object.
struct BoxFrame {
  std::int64_t timestamp_ns = 0;
  std::uint16_t class_id = 0;
  Se3 T_world_obj;
  Se3 T_obj_cam;
  std::optional<MaskEdges> edges;     ///< None: not detected in this frame.
  std::span<const BodyPoint> points;  ///< Of its reconstruction; without one, its stereo position.
  double disparity_sigma_px = 0.0;    ///< Of these points.
  Ground ground;                      ///< World frame; `down` is used even if the ground is not known.
  bool is_rotation_measured = false;  ///< T_world_obj follows the object's rotation.
  std::optional<Heading> heading;     ///< Of its motion in the world, if it moves.
};

/// Maximum a posteriori estimate of centre, yaw and size, with covariance, by robust Gauss-Newton over a few views of
/// the object. Evidence: the mask's edges (Bertoni et al. 2019 use its height, Mousavian et al. 2017 all four), the
/// reconstructed points on visible faces (L-shape fitting; Zhang et al. 2017), the ground, the direction of motion, and
/// the size prior of the class, which determines unseen sides. Of the frames from about the same side only the best one
/// counts, so that hundreds of similar views carry no more information than one.
class BoxEstimator {
 public:
  BoxEstimator(const SizeTable& sizes, const StereoGeometry& geometry, Arena& arena);
  void reset() noexcept;
  /// The object's frame has been replaced: discards earlier views, keeps the size.
  void forget_views() noexcept;
  [[nodiscard]] bool known() const noexcept { return known_; }
  void update(const BoxFrame& frame) noexcept;
  [[nodiscard]] Box3 box_in_object() const noexcept {
    return {state_.center_m, state_.size_m, state_.yaw_rad, down_obj_};
  }
  [[nodiscard]] Box3 box_in_world(const Se3& T_world_obj) const noexcept;
  /// Includes the deviations of other boxes that are nearly as probable.
  [[nodiscard]] Box3Sigma sigma() const noexcept;

 private:
  void keep_view(const BoxFrame& frame) noexcept;
  /// The kind that best fits the mask's height.
  [[nodiscard]] const KindOfObject& most_likely_kind(const BoxFrame& frame) const noexcept;
  /// A box of that kind turned by `yaw_rad`, behind the centre of the points.
  [[nodiscard]] BoxState start_at(const BoxFrame& frame, double yaw_rad, const KindOfObject& kind) const noexcept;
  void begin(const BoxFrame& frame, const BoxEvidence& evidence) noexcept;
  void test_hypothesis(const BoxEvidence& evidence, const BoxState& start, int iterations, double margin) noexcept;
  [[nodiscard]] BoxState next_hypothesis(const BoxFrame& frame, const BoxEvidence& evidence) const noexcept;
  /// Records a rejected box, less probable by `cost_difference`, twice the difference of log-likelihoods.
  void record_alternative(const BoxState& other, double cost_difference) noexcept;
  void update_heading(const BoxFrame& frame, const Ground& ground_obj) noexcept;
  void accept(const BoxFit& fit) noexcept;

  SizeTable sizes_;
  StereoGeometry geometry_;
  std::span<BoxView> views_;  ///< By the side from which the object is seen.
  BoxState state_;
  double cost_ = 0.0;
  Box3Sigma sigma_;        ///< Of the accepted box alone.
  Box3Sigma alternative_;  ///< Largest recent deviation of a rejected box, times the root of its probability.
  Eigen::Vector3d down_world_ = Eigen::Vector3d::UnitY();
  Eigen::Vector3d down_obj_ = Eigen::Vector3d::UnitY();
  std::optional<Heading> heading_;  ///< Newest one known, object frame.
  std::int64_t timestamp_ns_ = 0;
  std::uint32_t updates_ = 0;
  bool known_ = false;
};

}  // namespace kinetrace::trajectory
