// Names of object classes, for every output.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "kinetrace/core/detections.hpp"

namespace kinetrace {

/// "car", "pedestrian", "unknown", or "class_7" for any other class number. Never allocates.
class ClassName {
 public:
  explicit ClassName(std::uint16_t class_id) noexcept {
    switch (class_id) {
      case kUnknownClass: append("unknown"); break;
      case kVehicleClass: append("car"); break;
      case kPedestrianClass: append("pedestrian"); break;
      default:
        append("class_");
        size_ = static_cast<std::size_t>(
            std::to_chars(text_.data() + size_, text_.data() + text_.size() - 1, class_id).ptr - text_.data());
    }
  }

  [[nodiscard]] std::string_view view() const noexcept { return {text_.data(), size_}; }
  [[nodiscard]] const char* c_str() const noexcept { return text_.data(); }

 private:
  void append(std::string_view text) noexcept { size_ += text.copy(text_.data() + size_, text.size()); }

  std::array<char, 16> text_{};  // "class_65535", and the terminating zero.
  std::size_t size_ = 0;
};

}  // namespace kinetrace
