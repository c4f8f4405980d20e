// The pipeline's part in a test of publishing: results at 30 Hz.
#pragma once

#include <chrono>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "dds/publishing_thread.hpp"
#include "sample_results.hpp"
#include "test_domain.hpp"

namespace kinetrace::test {

/// The design load of publishing.
inline constexpr SampleContent kFull{.objects = 64, .background_points = 1360, .points_per_object = 10};

inline std::int64_t rss_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, 6, "VmRSS:") == 0) {
      return std::stoll(line.substr(6));
    }
  }
  return 0;
}

inline double thread_cpu_us() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// An app::PublishingThread on the loopback, and the producer of its results.
class PublishingLoad {
 public:
  using Samples = std::vector<std::unique_ptr<SampleResult>>;

  PublishingLoad() {
    config_.domain = test_domain();
    config_.bytes_per_second = 100'000'000;  // All data is sent, with any number of readers.
    arena_ = Arena(app::PublishingThread::required_bytes(config_));
    warm_up_ = make_samples(60);
    rss_before_kib_ = rss_kib();  // After all allocations of the test itself.
    auto thread = app::PublishingThread::create(
        config_, SampleResult::geometry(), [](const std::string&) {}, arena_);
    EXPECT_TRUE(thread) << thread.error().message;
    thread_ = std::move(*thread);
  }

  [[nodiscard]] int domain() const { return config_.domain; }
  [[nodiscard]] std::int64_t rss_added_kib() const { return rss_kib() - rss_before_kib_; }
  [[nodiscard]] std::uint64_t counter(const std::string& name) const {
    for (const auto& [known, value] : thread_->counters()) {
      if (known == name) {
        return value;
      }
    }
    ADD_FAILURE() << "no counter " << name;
    return 0;
  }

  /// As at the end of a run.
  void end() { thread_.reset(); }

  /// Two seconds, to reach the steady state.
  void warm_up() { static_cast<void>(offer(warm_up_)); }
  /// Made in advance, so that only offering them is measured.
  [[nodiscard]] Samples make_samples(int count) {
    Samples samples;
    for (int i = 0; i < count; ++i) {
      samples.push_back(std::make_unique<SampleResult>(kFull, frame_++));
    }
    return samples;
  }
  void offer(const SampleResult& sample) {
    thread_->offer_health(health_, sample.result.counters, sample.result.rig);
    thread_->offer(sample.result, 0);
    thread_->send();
  }
  /// Offers at 30 Hz; returns this thread's processor time of each offer.
  std::vector<double> offer(const Samples& samples) {
    std::vector<double> costs_us;
    auto next = std::chrono::steady_clock::now();
    for (const auto& sample : samples) {
      const double begun_us = thread_cpu_us();
      offer(*sample);
      costs_us.push_back(thread_cpu_us() - begun_us);
      next += std::chrono::nanoseconds(SampleResult::kPeriod_ns);
      std::this_thread::sleep_until(next);
    }
    return costs_us;
  }

 private:
  publishing::PublishConfig config_;
  Arena arena_;
  Samples warm_up_;
  std::int64_t rss_before_kib_ = 0;
  app::HealthMonitor health_;
  std::unique_ptr<app::PublishingThread> thread_;
  std::int64_t frame_ = 0;
};

}  // namespace kinetrace::test
