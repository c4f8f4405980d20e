// Report on an alignment and its uncertainty, as JSON and for a terminal.
#pragma once

#include <string>

#include "kinetrace/geo/alignment.hpp"
#include "kinetrace/geo/reference.hpp"

namespace kinetrace::map {

struct MapReport {
  std::string run;
  std::string format;  ///< Of the reference, and where it is.
  std::string path;
  const geo::Reference& reference;
  geo::AlignmentConfig config;
  const geo::Alignment& alignment;
};

/// map.json, see the README of modules/geo; in one line without `indent`.
[[nodiscard]] std::string report_json(const MapReport& report, int indent = 2);
/// Some lines for the terminal.
[[nodiscard]] std::string report_text(const MapReport& report);

}  // namespace kinetrace::map
