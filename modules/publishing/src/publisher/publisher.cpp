#include "kinetrace/publishing/publisher.hpp"

#include <atomic>
#include <utility>

#include "native/native_topics.hpp"
#include "native/trajectory_pieces.hpp"
#include "results/camera_motion.hpp"
#include "ros/ros_topics.hpp"
#include "transport/outbox.hpp"

namespace kinetrace::publishing {
namespace {

constexpr std::memory_order kRelaxed = std::memory_order_relaxed;

/// Message buffers and collected pieces, with the publisher's lifetime.
struct Buffers {
  Buffers(const PublishConfig& config, Arena& arena)
      : native(config, arena), ros(config, arena), trajectories(config, arena) {}
  NativeBuffers native;
  RosBuffers ros;
  TrajectoryPieces trajectories;
};

/// Writers, with the lifetime of their participant.
struct Topics {
  std::optional<NativeTopics> native;
  std::optional<RosTopics> ros;

  /// Errors: kIo.
  [[nodiscard]] static Result<Topics> create(const PublishConfig& config, const StereoGeometry& geometry,
                                             dds_entity_t participant, Buffers& buffers);
  /// Calls `publish(topics)` for each configured kind of topics.
  template <typename Publish>
  void for_each(Publish&& publish) {
    if (native) {
      publish(*native);
    }
    if (ros) {
      publish(*ros);
    }
  }
};

Result<Topics> Topics::create(const PublishConfig& config, const StereoGeometry& geometry, dds_entity_t participant,
                              Buffers& buffers) {
  Topics topics;
  if (config.native) {
    Result<NativeTopics> native = NativeTopics::create(config, geometry, buffers.native, participant);
    if (!native) {
      return Unexpected(native.error());
    }
    topics.native = std::move(*native);
  }
  if (config.ros2.enabled) {
    Result<RosTopics> ros = RosTopics::create(config, buffers.ros, participant);
    if (!ros) {
      return Unexpected(ros.error());
    }
    topics.ros = std::move(*ros);
  }
  return topics;
}

}  // namespace

struct Publisher::Impl {
  PublishConfig config;
  StereoGeometry geometry;
  Buffers buffers;
  Outbox outbox;
  std::unique_ptr<Link> link;
  CameraMotionMeter motion_meter{};
  std::optional<Topics> topics{};  ///< Declared after the link, so that they are destroyed first.
  std::uint64_t made_in = 0;       ///< Number of the membership in which the topics were created, or failed.
  std::optional<std::string> notice{};
  std::optional<std::int64_t> next_health_ns{};
  HealthState reported_state = HealthState::kOk;
  std::atomic<bool> has_topics = false;
  std::atomic<std::uint64_t> frames = 0;
  std::atomic<std::uint64_t> frames_without_link = 0;

  Status follow_link();
};

// Topics of the link's newest participant, if there is one.
Status Publisher::Impl::follow_link() {
  const LinkMembership membership = link->membership();
  if (membership.number == made_in) {
    return {};
  }
  made_in = membership.number;
  has_topics = false;
  topics.reset();
  if (membership.number == 0) {
    return {};
  }
  Result<Topics> made = Topics::create(config, geometry, membership.participant, buffers);
  if (!made) {
    return Unexpected(link->explained(made.error()));
  }
  topics = std::move(*made);
  has_topics = true;
  next_health_ns.reset();  // New readers receive it at once.
  topics->for_each([&](const auto& kind) { kind.publish(geometry, outbox); });
  return {};
}

Publisher::Publisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Publisher::~Publisher() = default;

std::size_t Publisher::required_bytes(const PublishConfig& config) {
  return measure_bytes([&](Arena& arena) { static_cast<void>(Buffers(config, arena)); });
}

std::size_t Publisher::participant_bytes(const PublishConfig& config) noexcept {
  constexpr std::size_t kMib = std::size_t{1024} * 1024;
  // Security adds plugins and libcrypto's tables.
  return (config.security.mode == SecurityMode::kRequired ? 10 : 4) * kMib;
}

Result<std::unique_ptr<Publisher>> Publisher::create(const PublishConfig& config, const StereoGeometry& geometry,
                                                     Arena& arena) {
  auto link = Link::create(config);
  if (!link) {
    return Unexpected(link.error());
  }
  const Buffers buffers(config, arena);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the publisher; size it from Publisher::required_bytes");
  }
  std::unique_ptr<Impl> impl(new Impl{.config = config,
                                      .geometry = geometry,
                                      .buffers = buffers,
                                      .outbox = Outbox(config.bytes_per_second, config.piece_bytes),
                                      .link = std::move(*link)});
  if (const Status made = impl->follow_link(); !made) {
    return Unexpected(made.error());
  }
  return std::unique_ptr<Publisher>(new Publisher(std::move(impl)));
}

void Publisher::supervise(std::int64_t now_ns) {
  Impl& self = *impl_;
  self.outbox.refill(now_ns);
  self.link->supervise(now_ns);
  if (const Status made = self.follow_link(); !made) {
    self.notice = "nothing is published until the network changes: " + made.error().message;
  }
}

const PublishedFrame* Publisher::serve(ResultMailbox& mailbox, std::int64_t now_ns) {
  supervise(now_ns);
  const PublishedFrame* frame = mailbox.fetch_frame();
  if (frame != nullptr) {
    publish(*frame, now_ns);
  }
  if (const PublishedHealth* health = mailbox.fetch_health()) {
    publish(*health, now_ns);
  }
  for (TrajectoryEvent event; mailbox.fetch(event);) {
    publish(event, now_ns);
  }
  return impl_->topics ? frame : nullptr;
}

void Publisher::publish(const PublishedFrame& frame, std::int64_t now_ns) {
  Impl& self = *impl_;
  self.outbox.refill(now_ns);
  const CameraMotion motion = self.motion_meter.update(frame);
  self.frames.fetch_add(1, kRelaxed);
  if (!self.topics) {
    self.frames_without_link.fetch_add(1, kRelaxed);
    return;
  }
  self.topics->for_each([&](auto& topics) { topics.publish(frame, motion, self.outbox); });
  if (self.topics->native) {
    self.topics->native->publish_points(frame, self.outbox);
  }
  if (self.topics->ros) {
    self.topics->ros->publish_drawings(frame, self.outbox);
  }
}

void Publisher::publish(const PublishedHealth& health, std::int64_t now_ns) {
  Impl& self = *impl_;
  self.outbox.refill(now_ns);
  const bool is_due = !self.next_health_ns || now_ns >= *self.next_health_ns || health.state != self.reported_state;
  if (!self.topics || !is_due) {
    return;
  }
  self.next_health_ns = now_ns + kHealthEvery_ns;
  self.reported_state = health.state;
  const PublishCounters sent = counters();
  self.topics->for_each([&](const auto& topics) { topics.publish(health, sent, self.outbox); });
}

void Publisher::publish(const TrajectoryEvent& event, std::int64_t now_ns) {
  Impl& self = *impl_;
  self.outbox.refill(now_ns);
  self.buffers.trajectories.add(event, [&self](const TrajectoryPart& part) {
    if (self.topics) {
      self.topics->for_each([&](const auto& topics) { topics.publish(part, self.outbox); });
    }
  });
}

std::optional<std::string> Publisher::take_notice() {
  return impl_->notice ? std::exchange(impl_->notice, std::nullopt) : impl_->link->take_notice();
}

LinkState Publisher::state() const noexcept {
  const LinkState state = impl_->link->state();
  return state == LinkState::kConnected && !impl_->has_topics ? LinkState::kFailed : state;
}

Link& Publisher::link() noexcept {
  return *impl_->link;
}

PublishCounters Publisher::counters() const noexcept {
  const Impl& self = *impl_;
  PublishCounters counters;
  self.outbox.count_into(counters);
  counters.frames = self.frames.load(kRelaxed);
  counters.frames_without_link = self.frames_without_link.load(kRelaxed);
  counters.participant_restarts = self.link->restarts();
  counters.log_lines = self.link->log_lines();
  counters.log_lines_suppressed = self.link->log_lines_suppressed();
  return counters;
}

}  // namespace kinetrace::publishing
