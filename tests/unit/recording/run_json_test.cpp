#include "run_json.hpp"

#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

using Json = nlohmann::json;

Json parse(const RunSummary& summary) {
  const Result<std::string> text = run_json_text(summary, {}, {});
  EXPECT_TRUE(text);
  return Json::parse(*text);
}

TEST(RunJson, HasTheDocumentedNames) {
  RunSummary summary;
  summary.version = "0.1.0";
  summary.config_json = R"({"features": {"max_features": 800}})";
  summary.dataset = {{"layout", "kitti-raw"}, {"path", "/data"}};
  summary.frames = 40;
  summary.frame_time = {.count = 40, .median_ms = 8.5, .p95_ms = 12.25, .max_ms = 20.0};
  summary.stage_times = {{"sfm", {.count = 40, .median_ms = 1.5, .p95_ms = 2.0, .max_ms = 3.0}}};
  summary.rss_peak_bytes = 64'000'000;
  summary.allocations_after_start = AllocationCounts{.own = 0, .foreign = 123};
  summary.counters.tracks_born = 6;
  summary.counters.background_lost_frames = 1;
  summary.camera_counters = {{"camera_frames_skipped", 2}};
  summary.pairing = {.offset_ms = 1.5, .drift_ppm = -20.0, .relearned = 3};
  summary.health = {.state = HealthState::kDegraded,
                    .worst = HealthState::kLost,
                    .camera = "streaming",
                    .entries = {{HealthReason::kCameraLost, 2, 10, 30}}};
  summary.warnings = {"first", "second"};
  summary.exit_status = 3;
  const Json run = parse(summary);
  EXPECT_EQ(run["version"], "0.1.0");
  EXPECT_EQ(run["config"]["features"]["max_features"], 800);
  EXPECT_EQ(run["dataset"]["layout"], "kitti-raw");
  EXPECT_EQ(run["frames"], 40);
  EXPECT_EQ(run["frame_ms"], (Json{{"median", 8.5}, {"p95", 12.25}, {"max", 20.0}}));
  EXPECT_EQ(run["stage_ms"]["sfm"]["p95"], 2.0);
  EXPECT_EQ(run["rss_peak_bytes"], 64'000'000);
  EXPECT_EQ(run["allocations_after_start"], 0);
  EXPECT_EQ(run["foreign_allocations_after_start"], 123);
  EXPECT_EQ(run["counters"]["tracks_born"], 6);
  EXPECT_EQ(run["counters"]["background_lost_frames"], 1);
  EXPECT_EQ(run["counters"]["camera_frames_skipped"], 2);
  EXPECT_EQ(run["pairing"], nlohmann::json({{"offset_ms", 1.5}, {"drift_ppm", -20.0}, {"relearned", 3}}));
  EXPECT_EQ(run["health"]["state"], "degraded");
  EXPECT_EQ(run["health"]["worst"], "lost");
  EXPECT_EQ(run["health"]["camera"], "streaming");
  EXPECT_EQ(run["health"]["reasons"],
            (Json{{{"reason", "camera_lost"}, {"count", 2}, {"first_frame", 10}, {"last_frame", 30}}}));
  EXPECT_EQ(run["warnings"], (Json{"first", "second"}));
  EXPECT_EQ(run["exit_status"], 3);
}

TEST(RunJson, AnEmptySummaryIsStillComplete) {
  const Json run = parse({});
  EXPECT_EQ(run["config"], Json::object());
  EXPECT_EQ(run["dataset"], Json::object());
  EXPECT_EQ(run["stage_ms"], Json::object());
  EXPECT_EQ(run["warnings"], Json::array());
  EXPECT_TRUE(run["allocations_after_start"].is_null()) << "not counted is not the same as none";
  EXPECT_EQ(run["counters"].size(), 17U);
}

TEST(RunJson, EscapesWhatJsonCannotHold) {
  RunSummary summary;
  const std::string nasty =
      "a \"quoted\" \\ path\n\twith \x01 and Stra\xc3\x9f"
      "e";
  summary.dataset = {{"path", nasty}};
  summary.warnings = {"broken \xff byte"};
  summary.frame_time.max_ms = std::numeric_limits<double>::infinity();
  const Json run = parse(summary);
  EXPECT_EQ(run["dataset"]["path"], nasty);
  EXPECT_EQ(run["warnings"][0], "broken \xef\xbf\xbd byte");
  EXPECT_TRUE(run["frame_ms"]["max"].is_null());
}

TEST(RunJson, RefusesAConfigurationThatIsNoObject) {
  for (const char* config : {"{", "[1]", "3", "{\"a\":1} x"}) {
    RunSummary summary;
    summary.config_json = config;
    const Result<std::string> text = run_json_text(summary, {}, {});
    ASSERT_FALSE(text) << config;
    EXPECT_EQ(text.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(RunJson, ListsTheFilesOfTheRun) {
  RecordingConfig config;
  config.mots = false;
  const std::vector<FileEntry> files =
      list_files(config, {.object_rows = 40, .tracks = 3, .object_clouds = 2, .object_models = 0});
  const Json run = Json::parse(*run_json_text({}, SyntheticRun::geometry(), files));
  const auto count = [&run](const char* path) {
    for (const Json& file : run["files"]) {
      if (file["path"] == path) {
        return file["count"].get<int>();
      }
    }
    return 0;
  };
  EXPECT_EQ(count("tracks/ID.tum"), 3);
  EXPECT_EQ(count("points/object_ID_model.ply"), 2);
  EXPECT_EQ(count("camera.tum"), 1);
  EXPECT_EQ(count("mots.txt"), 0);
  EXPECT_EQ(count("colmap/object_ID/images.txt"), 0);
  EXPECT_EQ(count("images/NAME.png"), 0);
  const auto objects = std::find_if(run["files"].begin(), run["files"].end(),
                                    [](const Json& file) { return file["path"] == "objects.csv"; });
  EXPECT_EQ(objects->at("rows"), 40);
  EXPECT_EQ(run["rectified"]["width_px"], SyntheticRun::kWidth);
}

}  // namespace
}  // namespace kinetrace::recording
