// From fixes in a file to a path: ordered in time, with counted irregularities.
#pragma once

#include <vector>

#include "kinetrace/geo/reference.hpp"

namespace kinetrace::geo {

/// Orders fixes by time, keeps the first of each time, counts gaps and jumps.
void make_path(std::vector<Fix>& fixes, ReferenceCounts& counts);

}  // namespace kinetrace::geo
