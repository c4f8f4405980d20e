// Receives masks over DDS into a mailbox, outside the pipeline's thread.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "kinetrace/publishing/mask_exchange.hpp"
#include "segmentation/mask_mailbox.hpp"

namespace kinetrace::app {

/// Sends requests and receives masks in a thread of its own.
class MaskThread {
 public:
  /// Created and destroyed by the pipeline's thread. `tell` receives notices for the user, called from this class's own
  /// thread. `link` and `mailbox` must outlive it; the caller supervises the link.
  MaskThread(publishing::Link& link, const std::string& device, MaskMailbox& mailbox,
             std::function<void(const std::string& line)> tell);
  MaskThread(const MaskThread&) = delete;
  MaskThread& operator=(const MaskThread&) = delete;
  ~MaskThread();

 private:
  void run();
  [[nodiscard]] Status serve();
  /// Reports each kind of refused message once.
  void report_refused();

  publishing::Link& link_;
  publishing::MaskReceiver receiver_;
  MaskMailbox& mailbox_;
  std::function<void(const std::string& line)> tell_;
  bool reported_other_run_ = false;
  bool reported_invalid_ = false;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace kinetrace::app
