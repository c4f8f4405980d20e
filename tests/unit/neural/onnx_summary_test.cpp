#include "onnx_summary.hpp"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace::neural {
namespace {

class OnnxSummaryTest : public ::testing::Test {
 protected:
  [[nodiscard]] Result<OnnxSummary> summary_of(const std::string& bytes) const {
    const std::string file = (folder_.path() / "model.onnx").string();
    std::ofstream(file, std::ios::binary) << bytes;
    return summarize_onnx(file);
  }
  /// A field of the wire format that holds bytes, shorter than 128.
  static std::string field(int number, const std::string& bytes) {
    return std::string{static_cast<char>(number << 3 | 2), static_cast<char>(bytes.size())} + bytes;
  }
  static std::string number(int field_number, int value) {
    return {static_cast<char>(field_number << 3), static_cast<char>(value)};
  }

  test::TempFolder folder_;
};

TEST_F(OnnxSummaryTest, OperatorsOpsetAndInputAreRead) {
  const std::string dimensions = field(1, number(1, 1)) + field(1, number(1, 3)) + field(1, field(2, "height"));
  const std::string input = field(1, "images") + field(2, field(1, field(2, dimensions)));
  const std::string graph = field(1, field(4, "Relu")) + field(1, field(4, "Conv")) + field(1, field(4, "Relu")) +
                            field(11, field(1, "weights")) + field(11, input) + field(5, field(8, "weights"));
  const Result<OnnxSummary> summary = summary_of(field(7, graph) + field(8, number(2, 12)));
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->opset, 12);
  EXPECT_EQ(summary->operators, (std::vector<std::string>{"Conv", "Relu"}));
  EXPECT_EQ(summary->input, (std::vector<std::int64_t>{1, 3, 0}));
}

TEST_F(OnnxSummaryTest, UnevenSplitsAreFoundAndEvenOnesAreFine) {
  const auto graph = [](int second) {
    const std::string sizes = field(8, "sizes") + number(2, 7) + number(7, 4) + number(7, second);
    return field(7, field(1, field(4, "Split") + field(1, "x") + field(1, "sizes")) + field(5, sizes));
  };
  EXPECT_TRUE(summary_of(graph(2))->has_uneven_split);
  EXPECT_FALSE(summary_of(graph(4))->has_uneven_split);
}

TEST_F(OnnxSummaryTest, TensorsWithoutAValueAreEmpty) {
  for (const int type : {1, 7}) {
    const std::string empty = field(8, "roi") + number(2, type) + field(4, "") + field(7, "") + field(9, "");
    const Result<OnnxSummary> summary = summary_of(field(7, field(5, empty)) + field(8, number(2, 12)));
    EXPECT_TRUE(summary) << summary.error().message;
  }
}

TEST_F(OnnxSummaryTest, WhatIsNoModelIsRefusedWhereverItEnds) {
  const std::string whole = field(7, field(1, field(4, "Conv"))) + field(8, number(2, 12));
  ASSERT_TRUE(summary_of(whole));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Result<OnnxSummary> summary = summary_of(whole.substr(0, size));
    const bool ends_between_fields = size == whole.size() - field(8, number(2, 12)).size();
    EXPECT_EQ(summary.has_value(), ends_between_fields) << size << " bytes";
  }
  EXPECT_EQ(summary_of("hello, this is not a model").error().code, ErrorCode::kBadFormat);
  EXPECT_EQ(summarize_onnx("/nowhere/model.onnx").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace kinetrace::neural
