#include "utc_time.hpp"

#include <gtest/gtest.h>

namespace kinetrace::geo {
namespace {

TEST(UtcTime, ReadsDatesWithAndWithoutZones) {
  constexpr std::int64_t kExpected_ns = 1'317'042'145'594'360'375;  // date --utc --date='2011-09-26 13:02:25' +%s
  EXPECT_EQ(parse_date_time_ns("2011-09-26 13:02:25.594360375"), kExpected_ns);
  EXPECT_EQ(parse_date_time_ns("2011-09-26T13:02:25.594360375Z"), kExpected_ns);
  EXPECT_EQ(parse_date_time_ns("2011-09-26T15:02:25.594360375+02:00"), kExpected_ns);
  EXPECT_EQ(parse_date_time_ns("2011-09-26T06:32:25.594360375-0630"), kExpected_ns);
  EXPECT_EQ(parse_date_time_ns("2011-09-26T13:02:25Z"), kExpected_ns - 594'360'375);
}

TEST(UtcTime, RefusesWhatIsNoTime) {
  for (const char* text :
       {"", "2011", "2011-13-26T13:02:25Z", "2011-02-30T13:02:25Z", "2011-09-26T24:02:25Z", "2011-09-26T13:60:25Z",
        "2011-09-26T13:02:61Z", "2011-09-26x13:02:25Z", "2011-09-26T13:02:25.Z", "2011-09-26T13:02:25.5x",
        "2011-09-26T13:02:25+2", "1969-12-31T23:59:59Z", "2011-09-26T13:02:25+99:00"}) {
    EXPECT_FALSE(parse_date_time_ns(text)) << text;
  }
  for (const char* text : {"", "1302", "13022", "130260.5.", "250000", "13:02:25"}) {
    EXPECT_FALSE(time_of_day_ns(text)) << text;
  }
}

TEST(UtcTime, WritesWhatItReads) {
  const std::string text = "2024-02-29T23:59:59.999Z";
  EXPECT_EQ(date_time_text(*parse_date_time_ns(text)), text);
  EXPECT_EQ(date_time_text(*parse_date_time_ns("2024-02-29T23:59:59.9996Z")), "2024-03-01T00:00:00.000Z");
}

}  // namespace
}  // namespace kinetrace::geo
