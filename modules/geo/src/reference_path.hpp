// From fixes in a file to a path: ordered in time, with counted irregularities.
#pragma once

#include <vector>

#include "kinetrace/geo/reference.hpp"

namespace kinetrace::geo {

/// Removes fixes that are not later than all before them, counts gaps and jumps.
void make_path(std::vector<Fix>& fixes, ReferenceCounts& counts);

}  // namespace kinetrace::geo
