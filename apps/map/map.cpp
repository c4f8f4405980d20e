#include "map.hpp"

#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "cli/failure.hpp"
#include "cli/messages.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/geo/map_files.hpp"
#include "live_map.hpp"
#include "map_picture.hpp"
#include "map_places.hpp"
#include "map_report.hpp"
#include "reference_arguments.hpp"
#include "run_trajectories.hpp"

namespace kinetrace::map {
namespace {

namespace fs = std::filesystem;
using app::failure;
using app::Failure;
using app::MapOptions;
using app::Outcome;

using TextOf = decltype(&geo::csv_text);
constexpr std::array<std::pair<std::string_view, TextOf>, 4> kTexts{
    {{kGeoJson, &geo::geojson_text}, {kKml, &geo::kml_text}, {kGpx, &geo::gpx_text}, {kCsv, &geo::csv_text}}};

fs::path folder_of(const MapOptions& options) {
  return options.out.empty() ? options.run / "map" : options.out;
}

Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return error ? fail(ErrorCode::kIo, "cannot make " + folder.string() + ": " + error.message()) : Status{};
}

Status write_map(const fs::path& folder, const recording::Run& run, const geo::Reference& reference,
                 const geo::Alignment& alignment) {
  const std::vector<geo::MapTrajectory> trajectories = map_trajectories(run, alignment);
  const geo::MapFileContext context{reference.frame, alignment.time_offset_s};
  for (const auto& [name, text_of] : kTexts) {
    if (Status written = replace_file(folder / name, text_of(trajectories, context)); !written) {
      return written;
    }
  }
  return write_map_picture(folder / kPicture, trajectories, reference, alignment);
}

int write_all(const MapOptions& options, const recording::Run& run, const MapReport& report) {
  const fs::path folder = folder_of(options);
  if (const Status made = make_folder(folder); !made) {
    return app::report({app::ExitCode::kCannotCreate, made.error().message});
  }
  const bool is_aligned = report.alignment.verdict == geo::Verdict::kAligned;
  const Status written =
      is_aligned ? write_map(folder, run, report.reference, report.alignment) : (remove_map(folder), Status{});
  const std::string json = report_json(report);
  if (const Status reported = written ? replace_file(folder / kReport, json) : written; !reported) {
    return app::report(app::to_failure(reported.error()));
  }
  if (options.json || !options.quiet) {
    std::fputs(options.json ? json.c_str() : report_text(report).c_str(), stdout);
  }
  if (!is_aligned) {
    return app::report({app::ExitCode::kBadData, "not aligned: " + report.alignment.reason});
  }
  if (!options.quiet && !options.json) {
    std::printf("files      trajectories.{geojson,kml,gpx,csv}, map.png and map.json in %s\n", folder.c_str());
  }
  return 0;
}

Outcome<int> make_map(const MapOptions& options) {
  if (options.run.empty()) {
    return Unexpected(
        Failure{app::ExitCode::kUsage, "RUN is missing: a run folder; only navsatfix:TOPIC goes without"});
  }
  if (!options.publish.empty() || options.seconds > 0.0) {
    return Unexpected(Failure{app::ExitCode::kUsage, "--publish and --seconds are for --reference navsatfix:TOPIC"});
  }
  const Outcome<geo::AlignmentConfig> config = parse_config(options.reference);
  if (!config) {
    return Unexpected(config.error());
  }
  const Result<recording::Run> run = recording::read_run(options.run);
  if (!run) {
    return failure(run.error());
  }
  for (const std::string& note : run->notes) {
    app::print_warning(note);
  }
  if (run->camera.size() < 2) {
    return Unexpected(Failure{app::ExitCode::kBadData, options.run.string() + ": has no path of the camera"});
  }
  const Outcome<geo::ReferenceSource> source = parse_source(options.reference, run->camera.front().timestamp_ns);
  if (!source) {
    return Unexpected(source.error());
  }
  if (const Status places = check_places(folder_of(options), *run, source->path); !places) {
    return failure(places.error());
  }
  const Result<geo::Reference> reference = geo::read_reference(*source);
  if (!reference) {
    return failure(reference.error());
  }
  for (const std::string& note : reference->notes) {
    app::print_warning(note);
  }
  const Result<geo::Alignment> alignment = geo::align(camera_path(*run), reference->fixes, *config);
  if (!alignment) {
    return failure(alignment.error());
  }
  return write_all(options, *run,
                   {options.run.string(), std::string(geo::to_string(source->format)), source->path.string(),
                    *reference, *config, *alignment});
}

}  // namespace

int map_command(const MapOptions& options) {
  const Outcome<int> exit_code = is_live(options.reference) ? follow_run(options) : make_map(options);
  return exit_code ? *exit_code : app::report(exit_code.error());
}

}  // namespace kinetrace::map
