#include "kinetrace/core/text_rows.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class TextRowsOfAFile : public ::testing::Test {
 protected:
  TextRows rows_of(const std::string& text, TextRows::Separator separator = TextRows::Separator::kBlanks) {
    std::ofstream(folder_.file("rows.txt"), std::ios::binary) << text;
    return TextRows::open(folder_.file("rows.txt"), separator).value();
  }
  static std::string message(const TextRows& rows) { return rows.status() ? "" : rows.status().error().message; }

  test::TempFolder folder_;
};

TEST_F(TextRowsOfAFile, SkipBlankLinesAndComments) {
  TextRows rows = rows_of("# names\r\n\n  1  2\t3 \r\n   \n4");
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.line(), 3);
  EXPECT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows.integer(2), 3);
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.line(), 5);
  EXPECT_EQ(rows.integer(0), 4);
  EXPECT_FALSE(rows.next());
  EXPECT_TRUE(rows.status());
}

TEST_F(TextRowsOfAFile, AreNoneInAnEmptyFile) {
  TextRows rows = rows_of("");
  EXPECT_FALSE(rows.next());
  EXPECT_TRUE(rows.status());
}

TEST_F(TextRowsOfAFile, KeepEmptyFieldsBetweenCommas) {
  TextRows rows = rows_of("a,, b ,", TextRows::Separator::kComma);
  ASSERT_TRUE(rows.next());
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows.text(0), "a");
  EXPECT_EQ(rows.text(1), "");
  EXPECT_EQ(rows.text(2), "b");
  EXPECT_EQ(rows.text(3), "");
}

TEST_F(TextRowsOfAFile, BeginAfterAByteOrderMark) {
  TextRows rows = rows_of(
      "\xEF\xBB\xBF"
      "a,b\n1,2\n",
      TextRows::Separator::kComma);
  EXPECT_THAT(rows.columns({"a", "b"}), ElementsAre(0U, 1U));
  EXPECT_TRUE(rows_of("\xEF\xBB\xBF").status());
}

TEST_F(TextRowsOfAFile, NameSemicolonsInPlaceOfCommas) {
  TextRows rows = rows_of("a;b\n1;2\n", TextRows::Separator::kComma);
  static_cast<void>(rows.columns({"a", "b"}));
  EXPECT_THAT(message(rows), HasSubstr("'a' is missing; expected commas between the fields, found semicolons"));
}

TEST_F(TextRowsOfAFile, StayReadableWhenMoved) {
  TextRows rows = rows_of("1 2\n");
  ASSERT_TRUE(rows.next());
  TextRows moved = std::move(rows);
  EXPECT_EQ(moved.text(1), "2");
}

TEST_F(TextRowsOfAFile, FindColumnsByName) {
  TextRows rows = rows_of("x,y,name\n1,2,a\n3,4\n", TextRows::Separator::kComma);
  EXPECT_THAT(rows.columns({"name", "x"}), ElementsAre(2U, 0U));
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.text(2), "a");
  EXPECT_FALSE(rows.next());
  EXPECT_THAT(message(rows), HasSubstr("rows.txt, line 3: expected 3 fields, found 2"));
}

TEST_F(TextRowsOfAFile, ReportAMissingColumn) {
  TextRows rows = rows_of("x,y\n1,2\n", TextRows::Separator::kComma);
  EXPECT_EQ(rows.columns({"x", "z"}).size(), 2U);
  EXPECT_THAT(message(rows), HasSubstr("line 1: column 'z' is missing"));
  EXPECT_FALSE(rows.next());
}

TEST_F(TextRowsOfAFile, ReportTheFirstMistakeAndStop) {
  TextRows rows = rows_of("1 2x\n3 4\n");
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.number(1), 0.0);
  EXPECT_EQ(rows.number(7), 0.0);
  EXPECT_FALSE(rows.next());
  EXPECT_THAT(message(rows), HasSubstr("rows.txt, line 1: '2x' is no finite number"));
}

TEST_F(TextRowsOfAFile, HaveNoNumbersThatAreNotFinite) {
  for (const char* text : {"nan", "inf", "-inf", "1e999", "0x10", "1,5", "+1"}) {
    EXPECT_FALSE(parse_number(text)) << text;
  }
  EXPECT_EQ(parse_number("-1.5e2"), -150.0);
  EXPECT_FALSE(parse_integer("1.0"));
  EXPECT_FALSE(parse_integer("99999999999999999999"));
}

TEST_F(TextRowsOfAFile, ReadTimesToTheNanosecond) {
  EXPECT_EQ(parse_time_ns("1767225600.100000001"), 1'767'225'600'100'000'001);
  EXPECT_EQ(parse_time_ns("1403636580838555648"), 1'403'636'580'838'555'648);
  EXPECT_EQ(parse_time_ns("1.036e-01"), 103'600'000);
  EXPECT_EQ(parse_time_ns("-0.5"), -500'000'000);
  EXPECT_EQ(parse_time_ns("1.767225600100000001e+09"), 1'767'225'600'100'000'001);
  EXPECT_EQ(parse_time_ns("1767225600"), 1'767'225'600'000'000'000);
  EXPECT_EQ(parse_time_ns("0.99999999951"), 1'000'000'000);
  EXPECT_EQ(parse_time_ns("4e-10"), 0);
  EXPECT_EQ(parse_time_ns("5e-10"), 1);
  EXPECT_EQ(parse_time_ns("5e-20"), 0);
  // Range in which the difference of two times always fits into 64 bits.
  EXPECT_EQ(parse_time_ns("4611686018427387903"), 4'611'686'018'427'387'903);
  EXPECT_FALSE(parse_time_ns("4611686018427387904"));
  EXPECT_FALSE(parse_time_ns("-4611686019"));
  EXPECT_FALSE(parse_time_ns("soon"));
  EXPECT_FALSE(parse_time_ns("1e12"));
  for (const char* no_time : {"", "-", ".", "1e", "1e1e1", "1.2.3", "1e+-3", "inf", "nan", "1e99"}) {
    EXPECT_FALSE(parse_time_ns(no_time)) << no_time;
  }
}

TEST_F(TextRowsOfAFile, ReadPosesInBothOrders) {
  TextRows rows = rows_of("1 2 3 1 0 0 0\n1 2 3 0.5 0 0 0\n");
  ASSERT_TRUE(rows.next());
  EXPECT_NEAR(so3_log(rows.pose(0).rotation).x(), 3.141592653589793, 1e-12);
  EXPECT_TRUE(rows.pose(0, TextRows::QuaternionOrder::kRealFirst).rotation.isIdentity());
  EXPECT_EQ(rows.pose(0).translation, Eigen::Vector3d(1, 2, 3));
  ASSERT_TRUE(rows.next());
  (void)rows.pose(0);
  EXPECT_THAT(message(rows), HasSubstr("line 2: the quaternion does not have length 1"));
}

TEST_F(TextRowsOfAFile, RefuseAMatrixThatIsNoRotation) {
  TextRows rows = rows_of("1 0 0 4 0 1 0 5 0 0 1 6\n1 0 0 4 0 1 0 5 0 0 -1 6\n");
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.matrix_pose(0).translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(rows.status());
  ASSERT_TRUE(rows.next());
  (void)rows.matrix_pose(0);
  EXPECT_THAT(message(rows), HasSubstr("line 2"));
}

TEST(TextRows, NeedAFile) {
  const Result<TextRows> rows = TextRows::open("/no/such/file", TextRows::Separator::kBlanks);
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(rows.error().message, HasSubstr("/no/such/file"));
  EXPECT_FALSE(TextRows::open("/tmp", TextRows::Separator::kBlanks));
}

}  // namespace
}  // namespace kinetrace
