#include "dds/mask_thread.hpp"

#include <utility>

namespace kinetrace::app {

MaskThread::MaskThread(publishing::Link& link, const std::string& device, MaskMailbox& mailbox,
                       std::function<void(const std::string& line)> tell)
    : link_(link), receiver_(link, device), mailbox_(mailbox), tell_(std::move(tell)) {
  mailbox_.on_request([&link] { link.wake(); });
  thread_ = std::thread([this] { run(); });
}

MaskThread::~MaskThread() {
  mailbox_.on_request(nullptr);
  ends_ = true;
  link_.wake();
  thread_.join();
}

Status MaskThread::serve() {
  if (Status taken = receiver_.take([this](const MaskMessage& message) { mailbox_.offer(message); }); !taken) {
    return taken;
  }
  mailbox_.set_senders(receiver_.senders());
  const std::optional<MaskRequest> request = mailbox_.take_request();
  return request ? receiver_.request(*request) : Status{};
}

void MaskThread::report_refused() {
  const MaskCounters counters = mailbox_.counters();
  constexpr const char* kRefused = "messages with masks are refused: ";
  if (counters.messages_of_other_run > 0 && !std::exchange(reported_other_run_, true)) {
    tell_(kRefused + std::string(kMasksOfOtherRun));
  }
  if (counters.messages_invalid > 0 && !std::exchange(reported_invalid_, true)) {
    tell_(kRefused + std::string(kMasksInvalid));
  }
}

void MaskThread::run() {
  // Bounds the delay until a new sender is noticed.
  constexpr std::int64_t kAtMost_ns = 50'000'000;
  bool was_reported = false;
  while (!ends_) {
    if (const Status served = serve(); !served && !std::exchange(was_reported, true)) {
      tell_("masks: " + served.error().message);
    }
    report_refused();
    link_.wait(kAtMost_ns);
  }
}

}  // namespace kinetrace::app
