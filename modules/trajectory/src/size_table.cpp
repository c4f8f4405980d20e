#include "kinetrace/trajectory/size_table.hpp"

#include <algorithm>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr std::uint16_t kOther = SizeTable::kOtherClasses;

// Means and deviations from the labels of KITTI (Geiger et al. 2012), lengths of cars and widths without mirrors from
// European registers. config/sizes.yaml is this table.
const std::array<KindOfObject, 14> kDefaultKinds{{
    {kVehicleClass, 0.79F, {4.25F, 1.50F, 1.76F}, {0.42F, 0.10F, 0.10F}, BodyShape::kSaloon},
    {kVehicleClass, 0.09F, {5.10F, 2.05F, 1.95F}, {0.50F, 0.22F, 0.12F}, BodyShape::kBox},
    {kVehicleClass, 0.04F, {6.60F, 2.70F, 2.20F}, {0.80F, 0.22F, 0.14F}, BodyShape::kBox},
    {kVehicleClass, 0.04F, {8.50F, 3.30F, 2.48F}, {2.00F, 0.30F, 0.12F}, BodyShape::kBox},
    {kVehicleClass, 0.03F, {11.5F, 3.20F, 2.55F}, {2.00F, 0.25F, 0.12F}, BodyShape::kBox},
    {kVehicleClass, 0.01F, {1.40F, 1.25F, 0.75F}, {0.50F, 0.30F, 0.20F}, BodyShape::kBox},
    {kPedestrianClass, 1.0F, {0.60F, 1.72F, 0.60F}, {0.20F, 0.13F, 0.15F}, BodyShape::kBox},
    {kUnknownClass, 0.55F, {4.25F, 1.50F, 1.76F}, {0.42F, 0.10F, 0.10F}, BodyShape::kSaloon},
    {kUnknownClass, 0.15F, {7.00F, 2.80F, 2.20F}, {2.50F, 0.60F, 0.30F}, BodyShape::kBox},
    {kUnknownClass, 0.20F, {0.60F, 1.72F, 0.60F}, {0.20F, 0.13F, 0.15F}, BodyShape::kBox},
    {kUnknownClass, 0.10F, {1.60F, 1.40F, 0.80F}, {0.60F, 0.40F, 0.30F}, BodyShape::kBox},
    {kOther, 0.60F, {1.40F, 1.30F, 0.80F}, {0.60F, 0.40F, 0.30F}, BodyShape::kBox},
    {kOther, 0.20F, {0.70F, 0.80F, 0.60F}, {0.40F, 0.40F, 0.30F}, BodyShape::kBox},
    {kOther, 0.20F, {6.00F, 2.60F, 2.20F}, {3.00F, 0.70F, 0.40F}, BodyShape::kBox},
}};

}  // namespace

SizeTable::SizeTable() : SizeTable(kDefaultKinds) {}

SizeTable::SizeTable(std::span<const KindOfObject> kinds) : count_(std::min(kinds.size(), kMaxKinds)) {
  std::copy_n(kinds.begin(), count_, kinds_.begin());
}

std::span<const KindOfObject> SizeTable::kinds_listed_for(std::uint16_t class_id) const noexcept {
  const auto is_of_class = [class_id](const KindOfObject& kind) { return kind.class_id == class_id; };
  const std::span<const KindOfObject> all = kinds();
  const auto first = std::find_if(all.begin(), all.end(), is_of_class);
  return {first, std::find_if_not(first, all.end(), is_of_class)};
}

std::span<const KindOfObject> SizeTable::kinds_of(std::uint16_t class_id) const noexcept {
  const std::span<const KindOfObject> own = kinds_listed_for(class_id);
  return own.empty() ? kinds_listed_for(kOtherClasses) : own;
}

}  // namespace kinetrace::trajectory
