// From fixes as files have them to a path: ordered in time, its irregularities counted.
#pragma once

#include <vector>

#include "kinetrace/geo/reference.hpp"

namespace kinetrace::geo {

/// Leaves out fixes that are not later than all before them, counts gaps and jumps.
void make_path(std::vector<Fix>& fixes, ReferenceCounts& counts);

}  // namespace kinetrace::geo
