// Explains refusals by the DDS library.
#pragma once

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// `error` quotes the DDS library, which does not know its configuration files. If one of them is the cause, the result
/// names it with the remedy; else it is `error`.
[[nodiscard]] Error explained(const PublishConfig& config, const Error& error);

}  // namespace kinetrace::publishing
