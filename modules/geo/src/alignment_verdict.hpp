// Whether an alignment is usable; if not, the remedy.
#pragma once

#include <span>
#include <string>

#include "alignment_model.hpp"
#include "normal_equations.hpp"

namespace kinetrace::geo {

/// Reason and remedy if reference and path hardly overlap in time; one line.
[[nodiscard]] std::string too_few_fixes(const AntennaPath& path, std::span<const Fix> fixes,
                                        const AlignmentConfig& config);

/// Reason and remedy of a refusal, one line; empty if there is none.
[[nodiscard]] std::string what_is_missing(const Alignment& alignment, std::span<const Residual> residuals,
                                          const AlignmentConfig& config);

}  // namespace kinetrace::geo
