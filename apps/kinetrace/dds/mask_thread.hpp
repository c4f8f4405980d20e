// Masks from the network into a mailbox, without the pipeline touching the network.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "kinetrace/publishing/mask_exchange.hpp"
#include "segmentation/mask_mailbox.hpp"

namespace kinetrace::app {

/// Listens in a thread of its own: requests go out, masks come in.
class MaskThread {
 public:
  /// Made and destroyed by the pipeline's thread. `tell` is called from its own with what the user should hear. `link`
  /// and `mailbox` outlive it; somebody else looks after the link.
  MaskThread(publishing::Link& link, const std::string& device, MaskMailbox& mailbox,
             std::function<void(const std::string& line)> tell);
  MaskThread(const MaskThread&) = delete;
  MaskThread& operator=(const MaskThread&) = delete;
  ~MaskThread();

 private:
  void run();
  [[nodiscard]] Status serve();
  /// Each once, as soon as there is something to say.
  void tell_of_refused();

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
