// Files for DDS Security: protection of a domain, and permissions of its participants.
#pragma once

#include <string>
#include <string_view>

#include "dds/authority.hpp"

namespace kinetrace::app {

enum class DdsRole {
  kDevice,     ///< Publishes results, reads masks.
  kViewer,     ///< Reads results.
  kSegmenter,  ///< Publishes masks, reads results.
};

[[nodiscard]] constexpr std::string_view to_string(DdsRole role) noexcept {
  switch (role) {
    case DdsRole::kDevice: return "device";
    case DdsRole::kViewer: return "viewer";
    case DdsRole::kSegmenter: return "segmenter";
  }
  return "viewer";
}

/// For all domains: authenticated participants only, everything encrypted.
[[nodiscard]] std::string governance_xml();

/// Permissions of the identity "CN=name"; everything else is denied. `ros_prefix`: value of dds.ros2.prefix.
[[nodiscard]] std::string permissions_xml(std::string_view name, DdsRole role, std::string_view ros_prefix,
                                          const Validity& validity);

/// "2027-01-31T12:00:00", UTC.
[[nodiscard]] std::string utc_text(std::int64_t time_s);

}  // namespace kinetrace::app
