// Checks of options' values. CLI11's own checks accept NaN and print the largest representable number.
#pragma once

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>

namespace kinetrace::app {

/// 1 or more, as far as an int goes.
inline CLI::Validator at_least_one() {
  const auto problem = [](const std::string& text) {
    constexpr int kMax = std::numeric_limits<int>::max();
    const double value = std::strtod(text.c_str(), nullptr);
    if (value > kMax) {
      return "must be at most " + std::to_string(kMax) + ", got " + text;
    }
    if (value != std::floor(value)) {
      return "must be a whole number, got " + text;
    }
    return value >= 1.0 ? std::string() : "must be 1 or more, got " + text;
  };
  return {problem, "POSITIVE", "positive"};
}

/// Both limits included.
inline CLI::Validator number_within(double least, double most) {
  std::ostringstream limits;
  limits << '[' << least << " - " << most << ']';
  const auto problem = [least, most, within = limits.str()](const std::string& text) {
    const double value = std::strtod(text.c_str(), nullptr);
    return value >= least && value <= most ? std::string() : "must be in " + within + ", got " + text;
  };
  return {problem, "FLOAT in " + limits.str(), "number"};
}

/// A picture is written as `suffix` whatever its name is: the names of other formats are refused.
inline auto named_as(const std::string& suffix) {
  return [suffix](const std::string& file) {
    std::string ending = std::filesystem::path(file).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const char* other : {".bmp", ".gif", ".jpeg", ".jpg", ".pdf", ".png", ".svg", ".tif", ".tiff", ".webp"}) {
      if (ending == other && ending != suffix) {
        return file + " would be no " + ending.substr(1) + "; name it " + suffix;
      }
    }
    return std::string();
  };
}

/// For all options of a command and of those below it. An empty value usually comes from an unset variable of a script
/// and must not pass for an option that was not given; where a value is missing, CLI11 takes the next option for it.
inline void refuse_missing_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    option->check([](const std::string& value) {
      if (value.starts_with("--")) {
        std::string problem = "needs a value, ";
        return problem.append(value).append(" is an option; a file of that name is ./").append(value);
      }
      return std::string(value.empty() ? "must not be empty" : "");
    });
  }
  for (CLI::App* below : command.get_subcommands({})) {  // Groups of options too.
    refuse_missing_values(*below);
  }
}

}  // namespace kinetrace::app
