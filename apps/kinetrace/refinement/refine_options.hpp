// What `kinetrace refine` is asked for. Known to the command, which only passes it on, and to the program that does it.
#pragma once

#include <filesystem>
#include <string>

#include "cli/companion.hpp"
#include "map/reference_options.hpp"

namespace kinetrace::app {

inline constexpr Companion kRefineCompanion{"kinetrace-refine", "kinetrace-refinement", "refining"};

struct RefineOptions {
  std::filesystem::path run;
  std::filesystem::path out;
  std::string dataset;  ///< LAYOUT:PATH; empty: where the run says.
  bool images = true;   ///< Of the recording; without them points are as the run saw them, and loops not looked for.
  bool loops = true;
  ReferenceOptions reference;  ///< Empty source: none.
  bool quiet = false;
};

void add_refine_options(CLI::App& command, RefineOptions& options);

}  // namespace kinetrace::app
