// Size priors of object classes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"

namespace kinetrace::trajectory {

/// Shape of a body within its box.
enum class BodyShape : std::uint8_t {
  kBox,     ///< Nearly all of it: vans, trucks, buses, people.
  kSaloon,  ///< A cabin on a lower body: cars.
};

/// One kind of object of a class: normal distributions of its length, height and width.
struct KindOfObject {
  std::uint16_t class_id = 0;
  float share = 1.F;  ///< Of the class.
  Eigen::Vector3f mean_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f sigma_m = Eigen::Vector3f::Zero();
  BodyShape shape = BodyShape::kBox;
};

/// The kinds of all classes. A class is a mixture of its kinds. No heap; copies share nothing.
class KINETRACE_API SizeTable {
 public:
  static constexpr std::size_t kMaxKinds = 24;
  static constexpr std::uint16_t kOtherClasses = 0xffff;  ///< Classes without a kind of their own.

  /// Cars, vans, trucks, buses, trolleys and scooters; people; any of these for objects without a class (moving
  /// regions); other classes.
  SizeTable();
  /// The table of these kinds alone, grouped by class. Kinds beyond kMaxKinds are left out.
  explicit SizeTable(std::span<const KindOfObject> kinds);

  [[nodiscard]] std::span<const KindOfObject> kinds() const noexcept { return std::span(kinds_).first(count_); }
  /// At least one if the table has any of kOtherClasses.
  [[nodiscard]] std::span<const KindOfObject> kinds_of(std::uint16_t class_id) const noexcept;

 private:
  [[nodiscard]] std::span<const KindOfObject> kinds_listed_for(std::uint16_t class_id) const noexcept;

  std::array<KindOfObject, kMaxKinds> kinds_;
  std::size_t count_ = 0;
};

}  // namespace kinetrace::trajectory
