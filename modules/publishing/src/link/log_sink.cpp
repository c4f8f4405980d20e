#include "link/log_sink.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

#include <dds/ddsrt/log.h>

namespace kinetrace::publishing {
namespace {

constexpr std::int64_t kMinute_ns = 60'000'000'000;

// The library has one sink for the whole process.
std::atomic<bool> is_taken{false};

void receive(void* sink, const dds_log_data_t* data) {
  static_cast<LogSink*>(sink)->add(data->message, std::strlen(data->message));
}

}  // namespace

Result<std::unique_ptr<LogSink>> LogSink::create(int lines_per_minute) {
  if (is_taken.exchange(true)) {
    return fail(ErrorCode::kIllegalState, "there is a publisher in this process already; use that one");
  }
  std::unique_ptr<LogSink> sink(new LogSink(lines_per_minute));
  dds_set_log_sink(receive, sink.get());
  dds_set_trace_sink(receive, sink.get());
  return sink;
}

LogSink::~LogSink() {
  dds_set_log_sink(nullptr, nullptr);
  dds_set_trace_sink(nullptr, nullptr);
  is_taken = false;
}

void LogSink::add(const char* line, std::size_t size) noexcept {
  // Further lines only repeat the first one.
  size = static_cast<std::size_t>(std::find(line, line + size, '\n') - line);
  while (size > 0 && line[size - 1] == ' ') {
    --size;
  }
  lines_.fetch_add(1, std::memory_order_relaxed);
  const std::lock_guard lock(mutex_);
  newest_.fill('\0');
  std::copy_n(line, std::min(size, newest_.size() - 1), newest_.begin());
  if (allowance_ <= 0 || count_ == kKept) {
    suppressed_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  --allowance_;
  kept_[(first_ + count_) % kKept] = newest_;
  ++count_;
}

void LogSink::tick(std::int64_t now_ns) noexcept {
  const std::lock_guard lock(mutex_);
  if (now_ns - minute_began_ns_ >= kMinute_ns) {
    minute_began_ns_ = now_ns;
    allowance_ = lines_per_minute_;
  }
}

std::optional<std::string> LogSink::take() {
  const std::lock_guard lock(mutex_);
  if (count_ == 0) {
    return std::nullopt;
  }
  const std::size_t first = first_;
  first_ = (first_ + 1) % kKept;
  --count_;
  return std::string(kept_[first].data());
}

std::string LogSink::take_reason() {
  const std::lock_guard lock(mutex_);
  std::string reason(newest_.data());
  newest_.fill('\0');
  return reason;
}

}  // namespace kinetrace::publishing
