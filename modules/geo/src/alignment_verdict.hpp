// Whether an alignment may be used, and if not, what to do about that.
#pragma once

#include <span>
#include <string>

#include "alignment_model.hpp"
#include "normal_equations.hpp"

namespace kinetrace::geo {

/// One line; where reference and path hardly share any time.
[[nodiscard]] std::string too_few_fixes(const AntennaPath& path, std::span<const Fix> fixes,
                                        const AlignmentConfig& config);

/// One line; empty if nothing is missing.
[[nodiscard]] std::string what_is_missing(const Alignment& alignment, std::span<const Residual> residuals,
                                          const AlignmentConfig& config);

}  // namespace kinetrace::geo
