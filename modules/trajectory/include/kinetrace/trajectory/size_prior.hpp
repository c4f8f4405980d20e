// How large objects of a class usually are.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace kinetrace::trajectory {

/// What a body fills of its box.
enum class BodyShape : std::uint8_t {
  kBox,      ///< Nearly all of it: vans, trucks, buses, people.
  kSaloon,   ///< A cabin on a lower body: cars.
};

/// One kind of object of a class: a normal distribution of its length, height and width.
struct KindOfObject {
  std::uint16_t class_id = 0;
  double share = 1.0;  ///< Of the class.
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  BodyShape shape = BodyShape::kBox;
};

/// The kinds of all classes; what has no class of its own, unknown ones too, may be any of kUnlisted.
[[nodiscard]] std::span<const KindOfObject> kinds_of(std::uint16_t class_id) noexcept;

}  // namespace kinetrace::trajectory
