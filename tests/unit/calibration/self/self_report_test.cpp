#include "self_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::self_calibration {
namespace {

using ::testing::HasSubstr;

TEST(SelfReport, IsWrittenForARecordingWhoseNameIsNotUtf8) {
  EXPECT_THAT(report_json({}, "folder:drive\xff"), HasSubstr("\"images\": \"folder:drive\xef\xbf\xbd\""));
}

}  // namespace
}  // namespace kinetrace::self_calibration
