// Names of classes as in a run's objects.csv.
#pragma once

#include <string>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::evaluation {

[[nodiscard]] inline std::string class_name(std::uint16_t class_id) {
  switch (class_id) {
    case kUnknownClass: return "unknown";
    case kVehicleClass: return "car";
    case kPedestrianClass: return "pedestrian";
    default: return "class_" + std::to_string(class_id);
  }
}

}  // namespace kinetrace::evaluation
