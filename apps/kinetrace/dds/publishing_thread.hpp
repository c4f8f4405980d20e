// Publishes results without blocking the pipeline.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dds/mask_thread.hpp"
#include "dds/run_publishing.hpp"
#include "kinetrace/publishing/publisher.hpp"
#include "kinetrace/publishing/result_mailbox.hpp"
#include "live/event_fd.hpp"

namespace kinetrace::app {

/// A Publisher in a thread of its own, behind a ResultMailbox. Offering costs a copy, send() one write to an eventfd,
/// independent of network and readers. Memory from the arena: mailbox and messages.
class PublishingThread final : public RunPublishing {
 public:
  /// Receives notices for the user; called from the thread.
  using Tell = std::function<void(const std::string& line)>;

  [[nodiscard]] static std::size_t required_bytes(const publishing::PublishConfig& config);
  /// Errors: as Publisher::create; kIo if the system has no eventfd left.
  [[nodiscard]] static Result<std::unique_ptr<PublishingThread>> create(const publishing::PublishConfig& config,
                                                                        const StereoGeometry& geometry, Tell tell,
                                                                        Arena& arena);
  ~PublishingThread() override { finish(); }
  PublishingThread(const PublishingThread&) = delete;
  PublishingThread& operator=(const PublishingThread&) = delete;
  PublishingThread(PublishingThread&&) = delete;
  PublishingThread& operator=(PublishingThread&&) = delete;

  void offer(const FrameResult& result, std::int64_t exposed_ns) noexcept override;
  void offer_finalised(const FrameResult& result) noexcept override;
  void offer_health(const HealthMonitor& health, const FrameCounters& counters,
                    const RigEstimate& rig) noexcept override;
  void send() noexcept override;
  [[nodiscard]] bool is_connected() const noexcept override;
  void receive_masks(MaskMailbox& mailbox) override;
  void finish() noexcept override;
  [[nodiscard]] recording::LatencySummary latency() const override { return latency_.quantiles(); }
  [[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> counters() const override;

 private:
  PublishingThread(std::unique_ptr<publishing::ResultMailbox> mailbox, std::unique_ptr<publishing::Publisher> publisher,
                   std::string device, Tell tell);
  void run();
  void serve();

  std::unique_ptr<publishing::ResultMailbox> mailbox_;
  std::unique_ptr<publishing::Publisher> publisher_;  ///< Used by the thread, except for state and counters.
  Tell tell_;
  std::string device_;
  std::unique_ptr<MaskThread>
      masks_;  ///< Null unless masks are received. Declared after the publisher, whose link it uses.
  recording::LatencyHistogram latency_;  ///< Of the thread.
  EventFd wake_event_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace kinetrace::app
