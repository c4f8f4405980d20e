// Options of `kinetrace refine`: shared by the command, which only passes them on, and the refinement program.
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
  std::string dataset;  ///< LAYOUT:PATH; empty: the run's recording.
  bool images = true;   ///< Use the recording's images; without them, points keep the run's observations and no loops
                        ///< are searched.
  bool loops = true;
  ReferenceOptions reference;  ///< Empty source: none.
  bool json = false;
  bool quiet = false;
};

void add_refine_options(CLI::App& command, RefineOptions& options);

}  // namespace kinetrace::app
