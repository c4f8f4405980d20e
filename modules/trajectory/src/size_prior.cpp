#include "kinetrace/trajectory/size_prior.hpp"

#include <array>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::trajectory {
namespace {

// Means and deviations as the labels of KITTI have them (Geiger et al. 2012), lengths of cars and widths without mirrors
// as European registers do.
const std::array<KindOfObject, 5> kVehicles{
    {{kVehicleClass, 0.80, {4.25, 1.50, 1.76}, {0.42, 0.10, 0.10}, BodyShape::kSaloon},
     {kVehicleClass, 0.09, {5.10, 2.05, 1.95}, {0.50, 0.22, 0.12}, BodyShape::kBox},
     {kVehicleClass, 0.04, {6.60, 2.70, 2.20}, {0.80, 0.22, 0.14}, BodyShape::kBox},
     {kVehicleClass, 0.04, {8.50, 3.30, 2.48}, {2.00, 0.30, 0.12}, BodyShape::kBox},
     {kVehicleClass, 0.03, {11.5, 3.20, 2.55}, {2.00, 0.25, 0.12}, BodyShape::kBox}}};
const std::array<KindOfObject, 1> kPeople{
    {{kPedestrianClass, 1.0, {0.60, 1.72, 0.60}, {0.20, 0.13, 0.15}, BodyShape::kBox}}};
const std::array<KindOfObject, 3> kOthers{{{0, 0.6, {1.40, 1.30, 0.80}, {0.60, 0.40, 0.30}, BodyShape::kBox},
                                           {0, 0.2, {0.70, 0.80, 0.60}, {0.40, 0.40, 0.30}, BodyShape::kBox},
                                           {0, 0.2, {6.00, 2.60, 2.20}, {3.00, 0.70, 0.40}, BodyShape::kBox}}};
const std::array<KindOfObject, 4> kAny{
    {{kUnknownClass, 0.55, {4.25, 1.50, 1.76}, {0.42, 0.10, 0.10}, BodyShape::kSaloon},
     {kUnknownClass, 0.15, {7.00, 2.80, 2.20}, {2.50, 0.60, 0.30}, BodyShape::kBox},
     {kUnknownClass, 0.20, {0.60, 1.72, 0.60}, {0.20, 0.13, 0.15}, BodyShape::kBox},
     {kUnknownClass, 0.10, {1.60, 1.40, 0.80}, {0.60, 0.40, 0.30}, BodyShape::kBox}}};

}  // namespace

std::span<const KindOfObject> kinds_of(std::uint16_t class_id) noexcept {
  switch (class_id) {
    case kVehicleClass: return kVehicles;
    case kPedestrianClass: return kPeople;
    case kUnknownClass: return kAny;
    default: return kOthers;
  }
}

}  // namespace kinetrace::trajectory
