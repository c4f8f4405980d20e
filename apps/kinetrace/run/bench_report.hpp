// Times of stages, as a table and as a file for later comparison.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/latency_histogram.hpp"

namespace kinetrace::app {

struct BenchReport {
  std::string version;
  std::string processor;  ///< Name reported by the system.
  std::string kernels;    ///< See kernel_isa.
  std::string dataset;
  int width_px = 0;  ///< Rectified.
  int height_px = 0;
  int repeats = 0;
  recording::TimingSummary frame;  ///< From rectification to trajectories, without decoding.
  std::vector<std::pair<std::string, recording::TimingSummary>> stages;
};

[[nodiscard]] std::string bench_json(const BenchReport& report);
/// Errors, with the file: kNotFound, kBadFormat.
[[nodiscard]] Result<BenchReport> read_bench_report(const std::filesystem::path& path);
/// `before` may be null; else the table adds each earlier median and the change in per cent.
[[nodiscard]] std::string bench_table(const BenchReport& report, const BenchReport* before);

}  // namespace kinetrace::app
