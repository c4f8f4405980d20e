// Properties of the board that a configuration is made for.
#pragma once

#include <string>

#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

/// Has no effect on a run; `plan` takes the image size from here and reports the share of the board's memory.
struct BoardConfig {
  std::string name{};         ///< Empty: no board in particular.
  int cores = 0;              ///< 0: unknown; likewise below.
  int memory_mib = 0;         ///< Total memory of the board.
  int image_width_px = 1242;  ///< Of one view.
  int image_height_px = 375;

  [[nodiscard]] Status validate() const {
    return first_failure({check_range("board.cores", cores, 0, 1024),
                          check_range("board.memory_mib", memory_mib, 0, 1 << 24),
                          check_range("board.image_width_px", image_width_px, 64, 8192),
                          check_range("board.image_height_px", image_height_px, 64, 8192)});
  }
};

template <typename Visitor>
void visit_fields(BoardConfig& config, Visitor&& visit) {
  visit("board.name", config.name,
        "name of the board that the configuration is made for; empty: no board in particular");
  visit("board.cores", config.cores, "number of processor cores; 0: not given");
  visit("board.memory_mib", config.memory_mib, "memory of the board, MiB; 0: not given");
  visit("board.image_width_px", config.image_width_px, "width of one view, px; `kinetrace plan` plans for it");
  visit("board.image_height_px", config.image_height_px, "height of one view, px; `kinetrace plan` plans for it");
}

}  // namespace kinetrace::app
