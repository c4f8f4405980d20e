#include "util/text_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/yaml_document.hpp"
#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ParseTime, ReadsDatesToTheNanosecond) {
  EXPECT_EQ(parse_time_ns("2011-09-26 14:06:03.368359168"), 1317045963368359168);
  EXPECT_EQ(parse_time_ns("1970-01-01 00:00:01.5"), 1500000000);
  EXPECT_EQ(parse_time_ns("1970-01-02 00:00:00"), 86400000000000);
}

TEST(ParseTime, ReadsSecondsAndNanoseconds) {
  EXPECT_EQ(parse_time_ns("1.036000e-01"), 103600000);
  EXPECT_EQ(parse_time_ns(" 12 "), 12000000000);
  EXPECT_EQ(parse_time_ns("1403715273262142976"), 1403715273262142976);
  EXPECT_NEAR(static_cast<double>(*parse_time_ns("1403715273.262142976") - 1403715273262142976), 0, 300);
}

TEST(ParseTime, ReadsDatesWithoutSeparators) {
  EXPECT_EQ(parse_calendar_ns("20110926140603"), 1317045963000000000);
  EXPECT_EQ(parse_calendar_ns("20110926140603368"), 1317045963368000000);
  EXPECT_EQ(parse_calendar_ns("20110926240603"), std::nullopt);
  EXPECT_EQ(parse_calendar_ns("00000000000012"), std::nullopt);
  EXPECT_EQ(parse_calendar_ns("2011092614060"), std::nullopt);
}

TEST(ParseTime, RefusesEverythingElse) {
  for (const char* text : {"",
                           "x",
                           "1.0 2.0",
                           "nan",
                           "inf",
                           "1e300",
                           "2011-13-26 14:06:03",
                           "2011-09-26",
                           "2011-09-26 14:06:03x1",
                           "2011-09-26 14:06:03.",
                           "2011-09-26 99:00:00",
                           "2011-09-26 14:60:00",
                           "2011-09-26 14:06:60",
                           "2011-02-29 14:06:03",
                           "2011-09-26 14-06-03",
                           "2011-09-26 -4:06:03",
                           "1969-12-31 23:59:59",
                           "2400-01-01 00:00:00",
                           "9999-12-31 23:59:59.999999999",
                           "9223372036854775807",
                           "5e9"}) {
    EXPECT_FALSE(parse_time_ns(text)) << text;
  }
}

TEST(ContentLines, LeaveOutCommentsAndBlanks) {
  EXPECT_THAT(content_lines("#head\r\n a b \r\n\n\tc"), ElementsAre("a b", "c"));
  EXPECT_TRUE(content_lines("").empty());
}

TEST(ReadText, LeavesOutTheByteOrderMark) {
  const kinetrace::test::TempFolder folder;
  const std::string path = folder.file("times.txt");
  test::write_text(path,
                   "\xEF\xBB\xBF"
                   "1.5\r\n2.5\r\n");
  const auto times = read_times_ns(path);
  ASSERT_TRUE(times) << times.error().message;
  EXPECT_EQ(times->front(), 1'500'000'000);
}

TEST(ParseNumbers, TakesBlanksAndCommas) {
  EXPECT_THAT(*parse_numbers(" 1, 2.5e1\t-3 "), ElementsAre(1.0, 25.0, -3.0));
  EXPECT_TRUE(parse_numbers("")->empty());
  EXPECT_FALSE(parse_numbers("1 two"));
}

class Yaml : public ::testing::Test {
 protected:
  Result<YamlDocument> load(const std::string& text) {
    test::write_text(path_, text);
    return YamlDocument::load(path_);
  }
  void expect_error(const Result<YamlDocument>& document, const char* what) {
    ASSERT_FALSE(document);
    EXPECT_EQ(document.error().code, ErrorCode::kBadCalibration);
    EXPECT_THAT(document.error().message, HasSubstr(path_));
    EXPECT_THAT(document.error().message, HasSubstr(what));
  }
  kinetrace::test::TempFolder folder_;
  std::string path_ = folder_.file("c.yaml");
};

TEST_F(Yaml, ReadsOpencvMatricesListsAndNestedLists) {
  const auto document = load(
      "%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: 2\n   cols: 2\n   dt: d\n   data: [ 1., 2., 3.5e+00, 4 ]\n"
      "cam0:\n  T: [[1, 2], [3, 4]]\n  n: 7\n");
  ASSERT_TRUE(document) << document.error().message;
  EXPECT_THAT(document->numbers("K").value(), ElementsAre(1, 2, 3.5, 4));
  EXPECT_THAT(document->numbers("cam0.T").value(), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(document->numbers("cam0.n", 1).value(), ElementsAre(7));
  EXPECT_TRUE(document->has("cam0.T"));
  EXPECT_FALSE(document->has("cam0.T.x"));
  EXPECT_FALSE(document->has("cam1"));
  EXPECT_EQ(document->first_of({"M", "K"}), "K");
}

TEST_F(Yaml, NamesTheKeyOfABadValue) {
  const auto document = load("a: [1, .nan]\nb: [1, x]\nc: [1, 2]\nd: {e: 1}\n");
  ASSERT_TRUE(document);
  EXPECT_THAT(document->numbers("a").error().message, HasSubstr("'a' holds nan"));
  EXPECT_THAT(document->numbers("b").error().message, HasSubstr("'b' holds 'x'"));
  EXPECT_THAT(document->numbers("c", 3).error().message, HasSubstr("'c' must be 3 numbers, got 2"));
  EXPECT_THAT(document->numbers("d").error().message, HasSubstr("'d' has no 'data'"));
  EXPECT_THAT(document->numbers("z").error().message, HasSubstr("'z' is missing"));
  EXPECT_THAT(document->text("c").error().message, HasSubstr("'c' is missing"));
}

TEST_F(Yaml, RejectsDuplicatesAndWhatIsNoMap) {
  expect_error(load("a: 1\nb:\n  c: 1\n  c: 2\n"), "'b.c' is there twice");
  expect_error(load("a: [1, 2\n"), "no valid YAML");
  expect_error(load("just text\n"), "no YAML map");
}

TEST_F(Yaml, ReplacesAliases) {
  const auto document = load("cam0: {size: &size [752, 480]}\ncam1: {size: *size}\n");
  ASSERT_TRUE(document) << document.error().message;
  EXPECT_THAT(document->numbers("cam1.size").value(), ElementsAre(752, 480));
}

TEST_F(Yaml, RejectsAliasesOfThemselves) {
  expect_error(load("a: 1\nself: &a {b: *a}\n"), "'self.b.b");
  expect_error(load("T: &t [*t, 0, 0]\n"), "'T' is nested more than 16 levels deep");
}

TEST_F(Yaml, RejectsAliasesThatMultiplyWithEveryLine) {
  const auto bomb = [](int lines, int times, const char* open, const char* key, const char* close) {
    std::string text = "a0: &a0 [1, 2]\n";
    for (int line = 1; line < lines; ++line) {
      const std::string number = std::to_string(line);
      text.append("a").append(number).append(": &a").append(number).append(" ").append(open);
      for (int i = 0; i < times; ++i) {
        text.append(i == 0 ? "" : ", ");
        if (*key != '\0') {
          text.append(key).append(std::to_string(i)).append(": ");
        }
        text.append("*a").append(std::to_string(line - 1));
      }
      text.append(close).append("\n");
    }
    return text;
  };
  expect_error(load(bomb(40, 2, "[", "", "]")), "levels deep; does an alias (*) contain itself?");
  expect_error(load(bomb(12, 8, "[", "", "]")), "holds more than 1048576 values once its aliases (*) are replaced");
  expect_error(load(bomb(12, 8, "{", "x", "}")), "holds more than 1048576 values once its aliases (*) are replaced");
}

TEST_F(Yaml, RejectsTreesThatAreNestedWithoutEnd) {
  expect_error(load(std::string("a: ").append(100'000, '[')), "no valid YAML");
  expect_error(load(std::string("a: ").append(100'000, '{')), "no valid YAML");
}

TEST_F(Yaml, RejectsFilesThatAreNoCalibrationBySize) {
  test::write_text(path_, std::string("a: ").append(std::size_t{1} << 20, '1') + "\n");
  const auto document = YamlDocument::load(path_);
  ASSERT_FALSE(document);
  EXPECT_THAT(document.error().message, HasSubstr(path_ + ": has 1048580 bytes; at most 1048576"));
}

TEST_F(Yaml, RejectsTransformsWithAnotherLastRow) {
  const auto document = load("T: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1]\n");
  ASSERT_TRUE(document);
  EXPECT_THAT(document->transform("T").error().message, HasSubstr("last row"));
}

}  // namespace
}  // namespace kinetrace::hal
