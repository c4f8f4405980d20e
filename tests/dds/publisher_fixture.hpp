// A publisher and its mailbox, with exactly the memory they require.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "kinetrace/publishing/publisher.hpp"
#include "kinetrace/publishing/result_mailbox.hpp"
#include "sample_results.hpp"
#include "test_domain.hpp"

namespace kinetrace::test {

class PublisherFixture {
 public:
  explicit PublisherFixture(publishing::PublishConfig config) : config_(std::move(config)) {
    config_.domain = test_domain();
    arena_ = Arena(publishing::ResultMailbox::required_bytes(config_) + publishing::Publisher::required_bytes(config_) +
                   Arena::kAlignment);
    auto mailbox = publishing::ResultMailbox::create(config_, arena_);
    auto publisher = publishing::Publisher::create(config_, SampleResult::geometry(), arena_);
    EXPECT_TRUE(mailbox) << mailbox.error().message;
    EXPECT_TRUE(publisher) << publisher.error().message;
    mailbox_ = std::move(*mailbox);
    publisher_ = std::move(*publisher);
  }

  [[nodiscard]] int domain() const { return config_.domain; }
  [[nodiscard]] publishing::ResultMailbox& mailbox() { return *mailbox_; }
  [[nodiscard]] publishing::Publisher& publisher() { return *publisher_; }

  /// Hands the result over at kHandedOver_ns and serves the mailbox. Each call is a second later.
  void publish(const SampleResult& sample) {
    mailbox_->offer(sample.result, kHandedOver_ns);
    serve();
  }
  void serve() {
    now_ns_ += 1'000'000'000;
    publisher_->serve(*mailbox_, now_ns_);
  }

  static constexpr std::int64_t kHandedOver_ns = 1'800'000'000'000'000'000;

 private:
  publishing::PublishConfig config_;
  Arena arena_;
  std::unique_ptr<publishing::ResultMailbox> mailbox_;
  std::unique_ptr<publishing::Publisher> publisher_;
  std::int64_t now_ns_ = 0;
};

}  // namespace kinetrace::test
