#include "dds/publishing_thread.hpp"

#include <pthread.h>
#include <sched.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "live/clocks.hpp"

namespace kinetrace::app {
namespace {

// Bounds the delay until a change of the network is noticed while no results arrive.
constexpr int kIdle_ms = 200;

// A SCHED_BATCH thread never preempts the thread that wakes it; otherwise sending would delay the pipeline on a busy
// machine. A refusal by the system is ignored.
void set_batch_scheduling() {
  const sched_param none{};
  ::pthread_setschedparam(::pthread_self(), SCHED_BATCH, &none);
}

}  // namespace

std::size_t PublishingThread::required_bytes(const publishing::PublishConfig& config) {
  return publishing::ResultMailbox::required_bytes(config) + publishing::Publisher::required_bytes(config) +
         Arena::kAlignment;
}

Result<std::unique_ptr<PublishingThread>> PublishingThread::create(const publishing::PublishConfig& config,
                                                                   const StereoGeometry& geometry, Tell tell,
                                                                   Arena& arena) {
  auto mailbox = publishing::ResultMailbox::create(config, arena);
  if (!mailbox) {
    return Unexpected(mailbox.error());
  }
  auto publisher = publishing::Publisher::create(config, geometry, arena);
  if (!publisher) {
    return Unexpected(publisher.error());
  }
  std::unique_ptr<PublishingThread> made(
      new PublishingThread(std::move(*mailbox), std::move(*publisher), config.device, std::move(tell)));
  if (!made->wake_event_.is_open()) {
    return fail(ErrorCode::kIo, "publishing needs one more open file than the process may have; raise its limit");
  }
  made->thread_ = std::thread([thread = made.get()] { thread->run(); });
  return made;
}

PublishingThread::PublishingThread(std::unique_ptr<publishing::ResultMailbox> mailbox,
                                   std::unique_ptr<publishing::Publisher> publisher, std::string device, Tell tell)
    : mailbox_(std::move(mailbox)),
      publisher_(std::move(publisher)),
      tell_(std::move(tell)),
      device_(std::move(device)) {}

void PublishingThread::offer(const FrameResult& result, std::int64_t exposed_ns) noexcept {
  mailbox_->offer(result, system_time_ns(), exposed_ns);
}

void PublishingThread::offer_finalised(const FrameResult& result) noexcept {
  mailbox_->offer_finalised(result);
}

void PublishingThread::offer_health(const HealthMonitor& health, const FrameCounters& counters,
                                    const RigEstimate& rig) noexcept {
  mailbox_->offer_health({.frame_index = health.frame(),
                          .handed_over_ns = system_time_ns(),
                          .state = health.state(),
                          .camera = to_string(health.camera()),
                          .entries = health.all(),
                          .counters = counters,
                          .rig = rig});
}

void PublishingThread::send() noexcept {
  wake_event_.signal();
}

bool PublishingThread::is_connected() const noexcept {
  return publisher_->state() == publishing::LinkState::kConnected;
}

void PublishingThread::receive_masks(MaskMailbox& mailbox) {
  masks_ = std::make_unique<MaskThread>(publisher_->link(), device_, mailbox, tell_);
}

void PublishingThread::serve() {
  const publishing::PublishedFrame* sent = publisher_->serve(*mailbox_, steady_time_ns());
  if (sent != nullptr && sent->exposed_ns != 0) {
    latency_.add(steady_time_ns() - sent->exposed_ns);
  }
  while (const std::optional<std::string> notice = publisher_->take_notice()) {
    tell_(*notice);
  }
}

void PublishingThread::run() {
  set_batch_scheduling();
  while (!ends_) {
    wake_event_.wait(kIdle_ms);
    serve();
  }
  serve();
}

void PublishingThread::finish() noexcept {
  if (!thread_.joinable()) {
    return;
  }
  masks_.reset();
  mailbox_->end_trajectories();
  ends_ = true;
  wake_event_.signal();
  thread_.join();
}

std::vector<std::pair<std::string, std::uint64_t>> PublishingThread::counters() const {
  const publishing::MailboxCounters handed_over = mailbox_->counters();
  std::vector<std::pair<std::string, std::uint64_t>> all{
      {"dds_frames_offered", handed_over.offered},
      {"dds_frames_superseded", handed_over.superseded},
      {"dds_trajectory_poses_dropped", handed_over.trajectory_poses_dropped}};
  const publishing::PublishCounters sent = publisher_->counters();
  for (const auto& [name, member] : publishing::kPublishCounterNames) {
    all.emplace_back(name, sent.*member);
  }
  return all;
}

}  // namespace kinetrace::app
