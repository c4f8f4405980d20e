// What `kinetrace refine` is asked for. Known to the command, which only passes it on, and to the program that does it.
#pragma once

#include <filesystem>

#include "cli/companion.hpp"

namespace kinetrace::app {

inline constexpr Companion kRefineCompanion{"kinetrace-refine", "kinetrace-refinement", "refining"};

struct RefineOptions {
  std::filesystem::path run;
  std::filesystem::path out;
  bool quiet = false;
};

void add_refine_options(CLI::App& command, RefineOptions& options);

}  // namespace kinetrace::app
