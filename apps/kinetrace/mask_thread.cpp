#include "mask_thread.hpp"

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

void MaskThread::run() {
  // How long a new sender may stay unnoticed.
  constexpr std::int64_t kAtMost_ns = 50'000'000;
  bool was_told = false;
  while (!ends_) {
    if (const Status served = serve(); !served && !std::exchange(was_told, true)) {
      tell_("masks: " + served.error().message);
    }
    link_.wait(kAtMost_ns);
  }
}

}  // namespace kinetrace::app
