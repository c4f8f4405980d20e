// Configuration files, on a small configuration of this test's own.
#include "config/config_file.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kinetrace::app {
namespace {

using ::testing::HasSubstr;

enum class Socket { kScrew, kPin };

constexpr std::string_view to_string(Socket socket) {
  return socket == Socket::kScrew ? "screw" : "pin";
}
bool from_string(std::string_view text, Socket& socket) {
  const bool known = text == "screw" || text == "pin";
  socket = known ? (text == "pin" ? Socket::kPin : Socket::kScrew) : socket;
  return known;
}

struct Lamp {
  bool lit = true;
  int bulbs = 3;
  float warmth = 0.5F;
  double watts = 40.25;
  std::string colour = "warm white";
  Socket socket = Socket::kScrew;
};

template <typename Visitor>
void visit_fields(Lamp& lamp, Visitor&& visit) {
  visit("lit", lamp.lit, "On at start.");
  visit("bulbs.count", lamp.bulbs, "How many.");
  visit("bulbs.inner.warmth", lamp.warmth, "0 cold, 1 warm.");
  visit("bulbs.inner.watts", lamp.watts, "Power, W.");
  visit("colour", lamp.colour, "A name.");
  visit("socket", lamp.socket, "screw or pin");
}

class ConfigFile : public ::testing::Test {
 protected:
  ~ConfigFile() override { std::filesystem::remove(path_); }

  Status read(std::string_view text) {
    std::ofstream(path_) << text;
    return read_config_file(path_, fields_of(lamp_));
  }
  /// The expected error's message when reading `text`.
  std::string error_of(std::string_view text) {
    const Status status = read(text);
    return status ? "no error" : status.error().message;
  }

  Lamp lamp_;
  std::filesystem::path path_ =
      std::filesystem::path(::testing::TempDir()) /
      (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".yaml");
};

TEST_F(ConfigFile, IsWrittenWithPathsThatAreNotUtf8) {
  lamp_.colour = "warm\xff";
  const std::string replaced = "\"warm\xef\xbf\xbd\"";
  EXPECT_THAT(to_yaml(fields_of(lamp_)), HasSubstr("colour: " + replaced + "\n"));
  EXPECT_THAT(to_json(fields_of(lamp_)), HasSubstr("\"colour\": " + replaced));
}

TEST_F(ConfigFile, AliasesOfThemselvesEndAtTheFirstUnknownKey) {
  EXPECT_THAT(error_of("bulbs: &b {inner: *b}\n"), HasSubstr(":1: "));
  EXPECT_THAT(error_of("a: &a {b: *a}\n"), HasSubstr(":1: "));
  std::string bomb = "m0: &m0 {x: 1}\n";
  for (int i = 1; i < 40; ++i) {
    const std::string name = std::string("m").append(std::to_string(i));
    const std::string last = std::string("*m").append(std::to_string(i - 1));
    bomb.append(name).append(": &").append(name).append(" {x: ").append(last).append(", y: ").append(last).append(
        "}\n");
  }
  EXPECT_THAT(error_of(bomb), HasSubstr(":1: "));
  EXPECT_THAT(error_of(std::string("bulbs: ").append(100'000, '[')), HasSubstr("not valid YAML"));
}

TEST_F(ConfigFile, SetsEveryTypeAndKeepsWhatItDoesNotName) {
  ASSERT_TRUE(
      read("lit: false\nsocket: pin\nbulbs:\n  count: 7\n  inner:\n    warmth: .25\n    watts: 1e3\n").has_value());
  EXPECT_FALSE(lamp_.lit);
  EXPECT_EQ(lamp_.socket, Socket::kPin);
  EXPECT_EQ(lamp_.bulbs, 7);
  EXPECT_EQ(lamp_.warmth, 0.25F);
  EXPECT_EQ(lamp_.watts, 1000.0);
  EXPECT_EQ(lamp_.colour, "warm white");
}

TEST_F(ConfigFile, AcceptsCommentsAndEmptySections) {
  EXPECT_TRUE(read("# nothing\n").has_value());
  EXPECT_TRUE(read("bulbs:\n  # count: 2\n").has_value());
  EXPECT_EQ(lamp_.bulbs, 3);
}

TEST_F(ConfigFile, AcceptsDottedKeys) {
  ASSERT_TRUE(read("bulbs.count: 4\n").has_value());
  EXPECT_EQ(lamp_.bulbs, 4);
}

TEST_F(ConfigFile, NamesFileLineAndNearestKeyOfAnUnknownKey) {
  const std::string message = error_of("lit: true\nbulbs:\n  cuont: 7\n");
  EXPECT_THAT(message, HasSubstr(path_.string() + ":3:"));
  EXPECT_THAT(message, HasSubstr("unknown key \"bulbs.cuont\"; did you mean bulbs.count?"));
}

TEST_F(ConfigFile, FindsAKeyOfAnotherSection) {
  EXPECT_THAT(error_of("watts: 7\n"), HasSubstr("did you mean bulbs.inner.watts?"));
}

TEST_F(ConfigFile, PointsToTheListWhenNothingIsNear) {
  EXPECT_THAT(error_of("ventilation: 7\n"), HasSubstr("`kinetrace config` lists all keys"));
}

TEST_F(ConfigFile, RefusesASecondDocument) {
  EXPECT_THAT(error_of("lit: true\n---\nlit: false\n"), HasSubstr(":2: a second document begins here"));
}

TEST_F(ConfigFile, RefusesARepeatedKey) {
  EXPECT_THAT(error_of("lit: true\ncolour: red\nlit: false\n"),
              HasSubstr(":3: \"lit\" is already given in line 1; keep one"));
  EXPECT_THAT(error_of("bulbs:\n  count: 1\nbulbs.count: 2\n"),
              HasSubstr("\"bulbs.count\" is already given in line 2"));
  EXPECT_THAT(error_of("bulbs:\n  count: 1\nbulbs:\n  inner:\n"), HasSubstr("\"bulbs\" is already given in line 1"));
}

TEST_F(ConfigFile, RefusesNumbersThatAreNotFinite) {
  for (const std::string text : {".nan", "nan", ".inf", "-inf", "1e999"}) {
    EXPECT_THAT(error_of("bulbs: {inner: {watts: " + text + "}}\n"),
                HasSubstr(":1: bulbs.inner.watts must be a finite number, got \"" + text + "\""));
  }
}

TEST_F(ConfigFile, RefusesValuesOfTheWrongType) {
  EXPECT_THAT(error_of("bulbs: {count: 2.5}\n"), HasSubstr("bulbs.count must be a whole number, got \"2.5\""));
  EXPECT_THAT(error_of("bulbs: {count: 99999999999}\n"), HasSubstr("must be a whole number"));
  EXPECT_THAT(error_of("lit: yes\n"), HasSubstr("lit must be true or false, got \"yes\""));
  EXPECT_THAT(error_of("socket: plug\n"), HasSubstr("socket must be screw or pin, got \"plug\""));
  EXPECT_THAT(error_of("socket: scerw\n"), HasSubstr("got \"scerw\"; did you mean screw?"));
  EXPECT_EQ(lamp_.socket, Socket::kScrew);
  EXPECT_THAT(error_of("bulbs: 3\n"), HasSubstr("\"bulbs\" is a section"));
  EXPECT_THAT(error_of("colour: [red]\n"), HasSubstr("colour must be one value"));
  EXPECT_THAT(error_of("colour:\n"), HasSubstr("colour must be one value"));
  EXPECT_THAT(error_of("- lit\n"), HasSubstr("expected lines of `key: value`"));
  EXPECT_THAT(error_of("lit: [\n"), HasSubstr("not valid YAML"));
}

TEST_F(ConfigFile, RefusesAnEmptyFile) {
  for (const std::string_view text : {"", "\n", " \r\n\t"}) {
    EXPECT_THAT(error_of(text), HasSubstr(": is empty; `kinetrace config` prints one"));
  }
}

TEST_F(ConfigFile, RefusesAMissingFileAndAFolder) {
  EXPECT_EQ(read_config_file("/nowhere/lamp.yaml", fields_of(lamp_)).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_config_file(::testing::TempDir(), fields_of(lamp_)).error().code, ErrorCode::kInvalidConfig);
}

TEST_F(ConfigFile, WrittenYamlReadsBackToTheSameValues) {
  lamp_ = {.lit = false,
           .bulbs = -2,
           .warmth = 0.1F,
           .watts = 1.0 / 3.0,
           .colour = "null \"and\" void: #1",
           .socket = Socket::kPin};
  const std::string yaml = to_yaml(fields_of(lamp_));
  EXPECT_THAT(yaml, HasSubstr("  inner:\n    # 0 cold, 1 warm.\n    warmth: 0.1\n"));
  Lamp written = lamp_;
  lamp_ = {};
  ASSERT_TRUE(read(yaml).has_value()) << error_of(yaml);
  EXPECT_EQ(lamp_.lit, written.lit);
  EXPECT_EQ(lamp_.bulbs, written.bulbs);
  EXPECT_EQ(lamp_.warmth, written.warmth);
  EXPECT_EQ(lamp_.watts, written.watts);
  EXPECT_EQ(lamp_.colour, written.colour);
  EXPECT_EQ(lamp_.socket, written.socket);
}

TEST_F(ConfigFile, JsonHoldsEveryFieldInItsType) {
  const auto json = nlohmann::json::parse(to_json(fields_of(lamp_)));
  EXPECT_EQ(json["lit"], true);
  EXPECT_EQ(json["bulbs"]["count"], 3);
  EXPECT_EQ(json["bulbs"]["inner"]["watts"], 40.25);
  EXPECT_EQ(json["colour"], "warm white");
  EXPECT_EQ(json["socket"], "screw");
}

TEST_F(ConfigFile, SettingChangesOneFieldAndNamesItsErrors) {
  const ConfigFields fields = fields_of(lamp_);
  ASSERT_TRUE(apply_setting("colour=a=b", fields).has_value());
  EXPECT_EQ(lamp_.colour, "a=b");
  EXPECT_THAT(apply_setting("colour", fields).error().message, HasSubstr("expected key=value"));
  EXPECT_THAT(apply_setting("=3", fields).error().message, HasSubstr("expected key=value"));
  EXPECT_THAT(apply_setting("bulbs.count=", fields).error().message, HasSubstr("must be a whole number, got \"\""));
  EXPECT_THAT(apply_setting("bulb.count=1", fields).error().message, HasSubstr("did you mean bulbs.count?"));
}

/// Some of the settings that were counted in frames.
struct Waits {
  double missed_s = 1.0;
  double unseen_s = 7.5;
};

template <typename Visitor>
void visit_fields(Waits& waits, Visitor&& visit) {
  visit("tracking.max_missed_s", waits.missed_s, "...");
  visit("tracking.max_unseen_s", waits.unseen_s, "...");
}

TEST(RenamedKeys, AreReadAsSecondsAndTheNewNameIsReported) {
  Waits waits;
  const ConfigFields fields = fields_of(waits);
  ConfigNotes notes;
  ASSERT_TRUE(read_config_text("old.yaml", "tracking: {max_missed_frames: 3}\n", fields, &notes));
  ASSERT_TRUE(apply_setting("tracking.max_unseen_frames=41", fields, &notes));
  EXPECT_EQ(waits.missed_s, 0.3);
  EXPECT_EQ(waits.unseen_s, 4.1);
  EXPECT_EQ(notes,
            (ConfigNotes{"tracking.max_missed_frames is now tracking.max_missed_s: 3 frames are read as 0.3 s",
                         "tracking.max_unseen_frames is now tracking.max_unseen_s: 41 frames are read as 4.1 s"}));
}

TEST(RenamedKeys, ThoseThatSayNothingAnyMoreStandBesideEachOther) {
  ConfigNotes notes;
  const Status read = read_config_text("old.yaml", "trajectory.box_percentile: 0.03\ntrajectory.min_box_size_m: 0.2\n",
                                       ConfigFields{}, &notes);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_THAT(notes[1], HasSubstr("trajectory.min_box_size_m has no effect any more"));
}

TEST(RenamedKeys, AreRefusedBesideTheNewNameAndWithAPartOfAFrame) {
  Waits waits;
  const ConfigFields fields = fields_of(waits);
  EXPECT_THAT(
      read_config_text("old.yaml", "tracking:\n  max_missed_s: 1\n  max_missed_frames: 3\n", fields).error().message,
      HasSubstr("old.yaml:3: \"tracking.max_missed_frames\" is already given in line 2"));
  EXPECT_THAT(apply_setting("tracking.max_missed_frames=2.5", fields).error().message,
              HasSubstr("must be a whole number, got \"2.5\"; it is called tracking.max_missed_s now, in seconds"));
}

struct Timeouts {
  double stall_ms = 500.0;
};

template <typename Visitor>
void visit_fields(Timeouts& timeouts, Visitor&& visit) {
  visit("timeouts.stall_ms", timeouts.stall_ms, "...");
}

TEST(RenamedKeys, OfTheSameUnitKeepTheirValue) {
  Timeouts timeouts;
  ConfigNotes notes;
  const Status read = read_config_text("camera.yaml", "patience:\n  stall_ms: 700\n", fields_of(timeouts), &notes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(timeouts.stall_ms, 700.0);
  EXPECT_EQ(notes, ConfigNotes{"patience.stall_ms is now timeouts.stall_ms"});
  EXPECT_THAT(read_config_text("camera.yaml", "patience: {lost_ms: 700}\n", fields_of(timeouts)).error().message,
              HasSubstr("patience.lost_ms"))
      << "not a key of this file";
}

}  // namespace
}  // namespace kinetrace::app
