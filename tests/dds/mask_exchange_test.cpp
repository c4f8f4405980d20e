// Masks and their requests, between the two sides.
#include "kinetrace/publishing/mask_exchange.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test_domain.hpp"

namespace kinetrace::publishing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kWidth = 64;
constexpr int kHeight = 48;

struct KeptMask {
  std::uint16_t class_id = 0;
  float score = 0.F;
  PixelBox box_px;
  std::vector<std::uint16_t> runs;
};

struct KeptMessage {
  std::uint64_t sender = 0;
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  View view = View::kLeft;
  std::uint32_t width_px = 0;
  std::uint32_t piece = 0;
  std::uint32_t pieces = 0;
  std::vector<KeptMask> masks;
};

class MaskExchange : public ::testing::Test {
 protected:
  void SetUp() override {
    PublishConfig config;
    config.domain = test::test_domain();
    link_ = Link::create(config).value();
    receiver_ = std::make_unique<MaskReceiver>(*link_, "front");
    sender_ = std::make_unique<MaskSender>(*link_, "front");
    ASSERT_TRUE(until([this] { return receiver_->senders() == 1; }));
  }
  void TearDown() override {
    sender_.reset();
    receiver_.reset();
  }

  /// Receives on both sides until `is_enough`.
  bool until(const std::function<bool()>& is_enough) {
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE(receiver_->take([this](const MaskMessage& message) { keep(message); }));
      const Result<std::optional<MaskRequest>> request = sender_->take_request();
      EXPECT_TRUE(request);
      request_ = *request ? *request : request_;
      if (is_enough()) {
        return true;
      }
      link_->wait(50'000'000);
    }
    return false;
  }
  void keep(const MaskMessage& message) {
    KeptMessage kept{message.sender,   message.frame_index, message.timestamp_ns, message.view,
                     message.width_px, message.piece,       message.pieces,       {}};
    for (const RunLengthMask& mask : message.masks) {
      kept.masks.push_back({mask.class_id, mask.score, mask.box_px, {mask.runs.begin(), mask.runs.end()}});
    }
    messages_.push_back(std::move(kept));
  }
  [[nodiscard]] static MaskSender::Image image() {
    return {.frame_index = 7, .timestamp_ns = 700, .view = View::kRight, .width_px = kWidth, .height_px = kHeight};
  }

  std::unique_ptr<Link> link_;
  std::unique_ptr<MaskReceiver> receiver_;
  std::unique_ptr<MaskSender> sender_;
  std::optional<MaskRequest> request_;
  std::vector<KeptMessage> messages_;
};

TEST_F(MaskExchange, ARequestReachesTheSender) {
  ASSERT_TRUE(receiver_->request({5, 500, 640, 480, true}));
  ASSERT_TRUE(until([this] { return request_.has_value(); }));
  EXPECT_EQ(request_->frame_index, 5);
  EXPECT_EQ(request_->timestamp_ns, 500);
  EXPECT_EQ(request_->width_px, 640U);
  EXPECT_EQ(request_->height_px, 480U);
  EXPECT_TRUE(request_->right);
}

TEST_F(MaskExchange, ASenderThatComesLateHearsTheNewestRequest) {
  sender_.reset();
  ASSERT_TRUE(receiver_->request({5, 500, 640, 480, false}));
  ASSERT_TRUE(receiver_->request({6, 600, 640, 480, false}));
  sender_ = std::make_unique<MaskSender>(*link_, "front");
  ASSERT_TRUE(until([this] { return request_.has_value(); }));
  EXPECT_EQ(request_->frame_index, 6);
}

TEST_F(MaskExchange, MasksArriveAsTheyWere) {
  MaskSender::Image sent = image();
  sent.masks = {{1, 0.75F, {2, 3, 6, 5}, {1, 2, 1, 4}}, {10, 1.F, {0, 0, kWidth, kHeight}, {0, kWidth * kHeight}}};
  ASSERT_TRUE(sender_->send(sent));
  ASSERT_TRUE(until([this] { return !messages_.empty(); }));
  const KeptMessage& message = messages_[0];
  EXPECT_EQ(message.frame_index, 7);
  EXPECT_EQ(message.timestamp_ns, 700);
  EXPECT_EQ(message.view, View::kRight);
  EXPECT_EQ(message.width_px, 64U);
  EXPECT_EQ(message.pieces, 1U);
  ASSERT_EQ(message.masks.size(), 2U);
  EXPECT_EQ(message.masks[0].class_id, 1);
  EXPECT_EQ(message.masks[0].score, 0.75F);
  EXPECT_EQ(message.masks[0].box_px.y1, 5);
  EXPECT_THAT(message.masks[0].runs, ElementsAre(1, 2, 1, 4));
  EXPECT_EQ(message.masks[1].class_id, kIgnoreClass);
}

TEST_F(MaskExchange, NoMasksIsAMessageToo) {
  ASSERT_TRUE(sender_->send(image()));
  ASSERT_TRUE(until([this] { return !messages_.empty(); }));
  EXPECT_EQ(messages_[0].pieces, 1U);
  EXPECT_TRUE(messages_[0].masks.empty());
}

TEST_F(MaskExchange, ManyMasksComeInPiecesInOrder) {
  MaskSender::Image sent = image();
  // Runs of one pixel each: the maximum of a mask.
  const std::vector<std::uint16_t> longest(std::size_t{kWidth} * kHeight, 1);
  for (std::uint16_t i = 0; i < 10; ++i) {
    sent.masks.push_back({i, 1.F, {0, 0, kWidth, kHeight}, longest});
  }
  for (std::uint16_t i = 10; i < 110; ++i) {
    sent.masks.push_back({i, 1.F, {0, 0, 1, 1}, {0, 1}});
  }
  ASSERT_TRUE(sender_->send(sent));
  ASSERT_TRUE(until([this] { return !messages_.empty() && messages_.size() == messages_[0].pieces; }));
  std::vector<std::uint16_t> order;
  for (std::size_t i = 0; i < messages_.size(); ++i) {
    EXPECT_EQ(messages_[i].piece, i);
    EXPECT_LE(messages_[i].masks.size(), kMaxMasksInMessage);
    std::size_t runs = 0;
    for (const KeptMask& mask : messages_[i].masks) {
      order.push_back(mask.class_id);
      runs += mask.runs.size();
    }
    EXPECT_LE(runs * sizeof(std::uint16_t), 16'000U);
  }
  std::vector<std::uint16_t> expected(110);
  std::iota(expected.begin(), expected.end(), std::uint16_t{0});
  EXPECT_EQ(order, expected);
}

TEST_F(MaskExchange, TellsSendersApart) {
  MaskSender other(*link_, "front");
  ASSERT_TRUE(other.take_request());
  ASSERT_TRUE(until([this] { return receiver_->senders() == 2; }));
  for (int i = 0; i < 2; ++i) {
    MaskSender::Image sent = image();
    ASSERT_TRUE(sender_->send(sent));
    sent.frame_index = 8;
    ASSERT_TRUE(other.send(sent));
  }
  ASSERT_TRUE(until([this] { return messages_.size() == 4; }));
  const auto same = [](const KeptMessage& a, const KeptMessage& b) {
    return (a.sender == b.sender) == (a.frame_index == b.frame_index);
  };
  for (const KeptMessage& message : messages_) {
    EXPECT_TRUE(same(message, messages_[0]));
  }
  EXPECT_TRUE(std::any_of(messages_.begin(), messages_.end(),
                          [this](const KeptMessage& message) { return message.sender != messages_[0].sender; }));
}

TEST_F(MaskExchange, MasksForAnotherDeviceAreNotReceived) {
  MaskSender other(*link_, "rear");
  ASSERT_TRUE(other.send(image()));
  ASSERT_TRUE(until([this] { return receiver_->senders() == 2; }));
  ASSERT_TRUE(sender_->send(image()));
  ASSERT_TRUE(until([this] { return !messages_.empty(); }));
  EXPECT_EQ(messages_.size(), 1U);
}

TEST_F(MaskExchange, TheSenderRefusesUnusableMasks) {
  const auto error_of = [this](const MaskSender::Image::Mask& mask) {
    MaskSender::Image sent = image();
    sent.masks = {mask};
    const Status refused = sender_->send(sent);
    EXPECT_FALSE(refused);
    return refused ? Error{} : refused.error();
  };
  EXPECT_EQ(error_of({1, 1.F, {0, 0, 4, 2}, {3, 4}}).code, ErrorCode::kInvalidArgument) << "adds up to 7 of 8";
  EXPECT_EQ(error_of({1, 1.F, {0, 0, kWidth + 1, 1}, {0, kWidth + 1}}).code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(error_of({1, 1.F, {3, 3, 3, 4}, {}}).code, ErrorCode::kInvalidArgument) << "empty box";
  std::vector<std::uint16_t> many(kMaxRunsOfMask + 1, 0);
  many.back() = 1;
  EXPECT_THAT(error_of({1, 1.F, {0, 0, 1, 1}, many}).message, AllOf(HasSubstr("4097 runs"), HasSubstr("frame 7")));
  many.pop_back();
  many.back() = 1;
  MaskSender::Image sent = image();
  sent.masks = {{1, 1.F, {0, 0, 1, 1}, many}};
  EXPECT_TRUE(sender_->send(sent)) << "as many as there may be";
}

}  // namespace
}  // namespace kinetrace::publishing
