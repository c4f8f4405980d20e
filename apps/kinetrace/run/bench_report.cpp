#include "run/bench_report.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

#include <nlohmann/json.hpp>

#include "kinetrace/recording/json_text.hpp"

namespace kinetrace::app {
namespace {

using Json = nlohmann::ordered_json;
using recording::TimingSummary;

Json timing_json(const TimingSummary& timing) {
  return {{"count", timing.count}, {"median", timing.median_ms}, {"p95", timing.p95_ms}, {"max", timing.max_ms}};
}

TimingSummary timing(const Json& json) {
  return {json.at("count").get<std::uint64_t>(), json.at("median").get<double>(), json.at("p95").get<double>(),
          json.at("max").get<double>()};
}

std::optional<TimingSummary> earlier(const BenchReport* before, const std::string& stage) {
  if (before == nullptr) {
    return std::nullopt;
  }
  const auto found = std::find_if(before->stages.begin(), before->stages.end(),
                                  [&](const auto& entry) { return entry.first == stage; });
  return found == before->stages.end() ? std::nullopt : std::optional(found->second);
}

std::string row(const std::string& name, const TimingSummary& now, const std::optional<TimingSummary>& before) {
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "%-16s %9.3f %9.3f %9.3f", name.c_str(), now.median_ms, now.p95_ms,
                now.max_ms);
  std::string text = line.data();
  if (before) {
    std::snprintf(line.data(), line.size(), " %9.3f", before->median_ms);
    text += line.data();
  }
  if (before && before->median_ms > 0.0) {
    std::snprintf(line.data(), line.size(), " %+7.1f %%", 100.0 * (now.median_ms / before->median_ms - 1.0));
    text += line.data();
  }
  return text + "\n";
}

std::string conditions(const BenchReport& report) {
  return report.dataset + ", " + std::to_string(report.width_px) + "x" + std::to_string(report.height_px) +
         " rectified, played " + std::to_string(report.repeats) + " times, " + std::to_string(report.frame.count) +
         " frames; " + report.kernels + " kernels on " + report.processor + "; kinetrace " + report.version;
}

}  // namespace

std::string bench_json(const BenchReport& report) {
  Json json{{"version", report.version}, {"processor", report.processor},         {"kernels", report.kernels},
            {"dataset", report.dataset}, {"width_px", report.width_px},           {"height_px", report.height_px},
            {"repeats", report.repeats}, {"frame_ms", timing_json(report.frame)}, {"stage_ms", Json::object()}};
  for (const auto& [name, timing] : report.stages) {
    json["stage_ms"][name] = timing_json(timing);
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<BenchReport> read_bench_report(const std::filesystem::path& path) {
  const Result<std::string> text = recording::read_json_text(path);
  if (!text) {
    return Unexpected(text.error());
  }
  try {
    const Json json = Json::parse(*text);
    BenchReport report{.version = json.at("version").get<std::string>(),
                       .processor = json.at("processor").get<std::string>(),
                       .kernels = json.at("kernels").get<std::string>(),
                       .dataset = json.at("dataset").get<std::string>(),
                       .width_px = json.at("width_px").get<int>(),
                       .height_px = json.at("height_px").get<int>(),
                       .repeats = json.at("repeats").get<int>(),
                       .frame = timing(json.at("frame_ms")),
                       .stages = {}};
    for (const auto& [name, stage] : json.at("stage_ms").items()) {
      report.stages.emplace_back(name, timing(stage));
    }
    return report;
  } catch (const Json::exception&) {
    return fail(ErrorCode::kBadFormat,
                path.string() + ": is not what `kinetrace bench --out` writes; write it anew, or give that file");
  }
}

std::string bench_table(const BenchReport& report, const BenchReport* before) {
  std::string text = conditions(report) + "\n";
  if (before != nullptr) {
    text += "before: " + conditions(*before) + "\n";
  }
  text += "\nstage, ms           median      95 %       max";
  text += before == nullptr ? "\n" : "    before   change\n";
  for (const auto& [name, timing] : report.stages) {
    text += row(name, timing, earlier(before, name));
  }
  return text + row("frame", report.frame, before == nullptr ? std::nullopt : std::optional(before->frame));
}

}  // namespace kinetrace::app
