// What the DDS library refuses, in words that help.
#pragma once

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// `error` quotes the DDS library, which does not know the files that it was configured from. Where one of them is to
/// blame, the result names it and says what to do; else it is `error`.
[[nodiscard]] Error explained(const PublishConfig& config, const Error& error);

}  // namespace kinetrace::publishing
