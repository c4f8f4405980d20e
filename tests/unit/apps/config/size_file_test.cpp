#include "config/size_file.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/core/detections.hpp"
#include "temp_folder.hpp"

namespace kinetrace::app {
namespace {

using testing::HasSubstr;
using trajectory::BodyShape;
using trajectory::SizeTable;

constexpr const char* kOther =
    "  - {class: other, share: 1.0, length: [1.0, 0.5], height: [1.0, 0.5], width: [1.0, 0.5], shape: box}\n";

Result<SizeTable> read(const std::string& text) {
  // A separate folder: tests run in parallel.
  const test::TempFolder folder;
  const std::string path = folder.file("sizes.yaml");
  std::ofstream(path) << text;
  return read_size_file(path);
}

std::string message(const std::string& text) {
  const Result<SizeTable> table = read(text);
  return table ? std::string() : table.error().message;
}

TEST(SizeFile, TheOneThatComesWithItIsTheTableWithoutAFile) {
  const Result<SizeTable> table = read_size_file(KINETRACE_SOURCE_DIR "/config/sizes.yaml");
  ASSERT_TRUE(table) << table.error().message;
  const SizeTable usual;
  for (const int class_id : {0, 1, 2, 3, 77}) {
    const auto expected = usual.kinds_of(static_cast<std::uint16_t>(class_id));
    const auto found = table->kinds_of(static_cast<std::uint16_t>(class_id));
    ASSERT_EQ(found.size(), expected.size()) << class_id;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].share, expected[i].share);
      EXPECT_EQ(found[i].mean_m, expected[i].mean_m);
      EXPECT_EQ(found[i].sigma_m, expected[i].sigma_m);
      EXPECT_EQ(found[i].shape, expected[i].shape);
    }
  }
}

TEST(SizeFile, AClassMayBeANumber) {
  const Result<SizeTable> table =
      read(std::string("kinds:\n") + kOther +
           "  - {class: 9, share: 0.5, length: [1.8, 0.1], height: [1.7, 0.1], width: [0.6, 0.1], shape: saloon}\n");
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(table->kinds_of(9).size(), 1U);
  EXPECT_EQ(table->kinds_of(9).front().shape, BodyShape::kSaloon);
  EXPECT_FLOAT_EQ(table->kinds_of(9).front().mean_m.x(), 1.8F);
  EXPECT_FLOAT_EQ(table->kinds_of(kVehicleClass).front().mean_m.x(), 1.F) << "not listed: like others";
}

TEST(SizeFile, NamesLineAndMistake) {
  EXPECT_THAT(message(""), HasSubstr(":1: expected one list"));
  EXPECT_THAT(message("kinds: 3\n"), HasSubstr("expected one list"));
  EXPECT_THAT(message("sizes:\n  - {}\n"), HasSubstr("expected one list"));
  EXPECT_THAT(message("kinds:\n  - car\n"), HasSubstr(":2: a kind must be a map"));
  EXPECT_THAT(message(std::string("kinds:\n") + kOther + "  - {class: cat}\n"), HasSubstr("got \"cat\""));
  EXPECT_THAT(
      message("kinds:\n  - {class: car, share: 0, length: [1, 1], height: [1, 1], width: [1, 1], shape: box}\n"),
      HasSubstr("share must be a number from 0.001 to 1"));
  EXPECT_THAT(
      message("kinds:\n  - {class: car, share: 1, length: [.nan, 1], height: [1, 1], width: [1, 1], shape: box}\n"),
      HasSubstr("length must be a number from 0.001 to 100"));
  EXPECT_THAT(
      message("kinds:\n  - {class: car, share: 1, length: [1, 1e-20], height: [1, 1], width: [1, 1], shape: box}\n"),
      HasSubstr("length must be a number from 0.001 to 100"));
  EXPECT_THAT(message("kinds:\n  - {class: car, class: other, share: 1}\n"), HasSubstr("\"class\" stands there twice"));
  EXPECT_THAT(message("kinds:\n  - {class: car, share: 1, length: 4, height: [1, 1], width: [1, 1], shape: box}\n"),
              HasSubstr("length must be [mean, standard deviation] in m"));
  EXPECT_THAT(
      message("kinds:\n  - {class: car, share: 1, length: [1, 1], height: [1, 1], width: [1, 1], shape: egg}\n"),
      HasSubstr("shape must be box or saloon"));
  EXPECT_THAT(message("kinds:\n  - {class: car, weight: 2}\n"), HasSubstr("unknown key \"weight\""));
  EXPECT_THAT(
      message("kinds:\n  - {class: car, share: 1, length: [1, 1], height: [1, 1], width: [1, 1], shape: box}\n"),
      HasSubstr("no kind of class `other`"));
  std::string many = "kinds:\n";
  for (std::size_t i = 0; i <= SizeTable::kMaxKinds; ++i) {
    many += kOther;
  }
  EXPECT_THAT(message(many), HasSubstr("24 is the most"));
  EXPECT_THAT(message("kinds: [\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(message(std::string("kinds:\n") + kOther + "---\nkinds: []\n"), HasSubstr(":3: a second document"));
  const Result<SizeTable> missing = read_size_file("/nonexistent/sizes.yaml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace kinetrace::app
