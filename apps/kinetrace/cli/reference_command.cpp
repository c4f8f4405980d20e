// The command line as a manual page, and as completion for a shell.
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

#include "cli/command_reference.hpp"
#include "cli/commands.hpp"
#include "config/board_profiles.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/fault_injector.hpp"
#include "kinetrace/segmentation/config.hpp"

namespace kinetrace::app {
namespace {

// For completion: suggested values of options that accept others, too.
ValueHints value_hints() {
  ValueHints hints;
  for (const std::string_view layout : hal::layout_names()) {
    hints["--dataset"].push_back(std::string(layout) + ":");
  }
  for (const segmentation::SegmentationMode mode : segmentation::kSegmentationModes) {
    const bool takes_folders = mode == segmentation::SegmentationMode::kMasks;
    hints["--segmentation"].push_back(std::string(to_string(mode)) + (takes_folders ? ":" : ""));
  }
  for (const std::string_view kind : hal::fault_kind_names()) {
    hints["--fault"].push_back(std::string(kind) + "@");
  }
  for (const BoardProfile& profile : board_profiles()) {
    hints["--board"].emplace_back(profile.name);
  }
  // Parsed by another program, which has the table of values.
  hints["--reference"] = {"oxts:", "euroc:", "nmea:", "gpx:", "csv:"};
  hints["map --reference"] = {"navsatfix:"};
  return hints;
}

}  // namespace

Action add_reference(CLI::App& command) {
  const auto form = std::make_shared<std::string>();
  command.add_option("FORM", *form, "man: a page for man(1); bash: completion, source <(kinetrace reference bash)")
      ->required()
      ->check(CLI::IsMember({"man", "bash"}));
  // Generated here, while the command line exists.
  const auto text = std::make_shared<std::string>();
  command.callback([form, text, &program = *command.get_parent()] {
    *text = *form == "man" ? manual_page(program) : bash_completion(program, value_hints());
  });
  return [text] {
    std::fputs(text->c_str(), stdout);
    return 0;
  };
}

}  // namespace kinetrace::app
