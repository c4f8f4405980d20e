#include "kinetrace/publishing/publisher.hpp"

#include <atomic>
#include <chrono>
#include <utility>

#include "camera_motion.hpp"
#include "domain_config.hpp"
#include "log_sink.hpp"
#include "native_topics.hpp"
#include "network_interface.hpp"
#include "outbox.hpp"
#include "participant.hpp"
#include "ros_topics.hpp"
#include "security_files.hpp"
#include "trajectory_pieces.hpp"

namespace kinetrace::publishing {
namespace {

constexpr std::memory_order kRelaxed = std::memory_order_relaxed;

std::int64_t system_time_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// Where messages are filled in, and what is gathered for them; as long as the publisher lives.
struct Buffers {
  Buffers(const PublishConfig& config, Arena& arena)
      : native(config, arena), ros(config, arena), trajectories(config, arena) {}
  NativeBuffers native;
  RosBuffers ros;
  TrajectoryPieces trajectories;
};

/// As long as the interface keeps its address.
struct Session {
  Participant participant;
  std::optional<NativeTopics> native;  // After the participant, so that topics go first.
  std::optional<RosTopics> ros;

  /// Errors: those of Participant and of the topics.
  [[nodiscard]] static Result<Session> create(const PublishConfig& config, const std::string& xml, Buffers& buffers,
                                              LogSink& log);
  /// Calls `publish(topics)` for each kind that is wanted.
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

Result<Session> Session::create(const PublishConfig& config, const std::string& xml, Buffers& buffers, LogSink& log) {
  Result<Participant> participant = Participant::create(config.domain, xml, log);
  if (!participant) {
    return tl::unexpected(participant.error());
  }
  Session session{std::move(*participant), std::nullopt, std::nullopt};
  if (config.native) {
    Result<NativeTopics> native = NativeTopics::create(config, buffers.native, session.participant.get());
    if (!native) {
      return tl::unexpected(native.error());
    }
    session.native = std::move(*native);
  }
  if (config.ros2.enabled) {
    Result<RosTopics> ros = RosTopics::create(config, buffers.ros, session.participant.get());
    if (!ros) {
      return tl::unexpected(ros.error());
    }
    session.ros = std::move(*ros);
  }
  return session;
}

}  // namespace

struct Publisher::Impl {
  PublishConfig config;
  StereoGeometry geometry;
  std::string own_xml;  ///< Empty: the configuration is made from the keys.
  Buffers buffers;
  Outbox outbox;
  std::unique_ptr<LogSink> log;
  CameraMotionMeter motion_meter{};
  std::optional<InterfaceAddress> address{};  ///< What the session was made with.
  std::optional<Session> session{};
  std::optional<std::int64_t> next_look_ns{};
  std::optional<std::int64_t> next_try_ns{};
  std::optional<std::string> notice{};
  bool was_connected = false;
  std::optional<std::int64_t> next_health_ns{};
  HealthState told_state = HealthState::kOk;
  std::atomic<LinkState> state = LinkState::kWaiting;
  std::atomic<std::uint64_t> frames = 0;
  std::atomic<std::uint64_t> frames_without_link = 0;
  std::atomic<std::uint64_t> restarts = 0;

  Status connect();
  void look_at_interface(std::int64_t now_ns);
  void disconnect(const std::string& why);
};

Status Publisher::Impl::connect() {
  if (config.security.mode == SecurityMode::kRequired) {
    // Again at every start of a participant: certificates expire.
    if (const Status secure = check_security_files(config.security, system_time_s()); !secure) {
      return secure;
    }
  }
  const bool has_multicast = address && address->multicast;
  const std::string xml = own_xml.empty() ? domain_xml(config, has_multicast) : own_xml;
  Result<Session> made = Session::create(config, xml, buffers, *log);
  if (!made) {
    return tl::unexpected(made.error());
  }
  session = std::move(*made);
  if (was_connected) {
    restarts.fetch_add(1, kRelaxed);
  }
  was_connected = true;
  state = LinkState::kConnected;
  next_health_ns.reset();  // New readers hear of it at once.
  session->for_each([&](const auto& topics) { topics.publish(geometry, outbox); });
  return {};
}

void Publisher::Impl::disconnect(const std::string& why) {
  session.reset();
  state = LinkState::kWaiting;
  notice = why;
}

// With a configuration of the user's own nobody knows which interface it means.
void Publisher::Impl::look_at_interface(std::int64_t now_ns) {
  if (!own_xml.empty() || (next_look_ns && now_ns < *next_look_ns)) {
    return;
  }
  next_look_ns = now_ns + kLookEvery_ns;
  const std::optional<InterfaceAddress> found = find_interface(config.interface);
  if (found == address) {
    return;
  }
  address = found;
  next_try_ns = now_ns;
  disconnect(found ? "publishing goes on: interface " + config.interface + " has address " + found->ipv4
                   : "publishing waits: interface " + config.interface + " is not there or has no address (there are " +
                         interface_names() + ")");
}

Publisher::Publisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Publisher::~Publisher() = default;

std::size_t Publisher::required_bytes(const PublishConfig& config) {
  return measure_bytes([&](Arena& arena) { static_cast<void>(Buffers(config, arena)); });
}

std::size_t Publisher::participant_bytes() noexcept {
  constexpr std::size_t kMib = 1024U * 1024U;
  return 12 * kMib;
}

Result<std::unique_ptr<Publisher>> Publisher::create(const PublishConfig& config, const StereoGeometry& geometry,
                                                     Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return tl::unexpected(valid.error());
  }
  std::string own_xml;
  if (!config.xml.empty()) {
    Result<std::string> read = read_own_xml(config);
    if (!read) {
      return tl::unexpected(read.error());
    }
    own_xml = std::move(*read);
  }
  auto log = LogSink::create(config.log_lines_per_minute);
  if (!log) {
    return tl::unexpected(log.error());
  }
  const Buffers buffers(config, arena);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the publisher; size it from Publisher::required_bytes");
  }
  std::unique_ptr<Impl> impl(new Impl{.config = config,
                                      .geometry = geometry,
                                      .own_xml = std::move(own_xml),
                                      .buffers = buffers,
                                      .outbox = Outbox(config.bytes_per_second, config.piece_bytes),
                                      .log = std::move(*log)});
  impl->address = impl->own_xml.empty() ? find_interface(config.interface) : std::nullopt;
  if (impl->address || !impl->own_xml.empty()) {
    if (const Status connected = impl->connect(); !connected) {
      return tl::unexpected(connected.error());
    }
  } else {
    if (config.security.mode == SecurityMode::kRequired) {
      if (const Status secure = check_security_files(config.security, system_time_s()); !secure) {
        return tl::unexpected(secure.error());
      }
    }
    impl->disconnect("publishing waits: interface " + config.interface + " is not there or has no address (there are " +
                     interface_names() + ")");
  }
  return std::unique_ptr<Publisher>(new Publisher(std::move(impl)));
}

void Publisher::supervise(std::int64_t now_ns) {
  Impl& self = *impl_;
  self.log->tick(now_ns);
  self.outbox.refill(now_ns);
  self.look_at_interface(now_ns);
  if (self.session || !self.address || (self.next_try_ns && now_ns < *self.next_try_ns)) {
    return;
  }
  if (const Status connected = self.connect(); !connected) {
    self.state = LinkState::kFailed;
    self.notice = "publishing failed, tried again in a few seconds: " + connected.error().message;
    self.next_try_ns = now_ns + kRetryEvery_ns;
  }
}

void Publisher::serve(ResultMailbox& mailbox, std::int64_t now_ns) {
  supervise(now_ns);
  if (const PublishedFrame* frame = mailbox.fetch_frame()) {
    publish(*frame, now_ns);
  }
  if (const PublishedHealth* health = mailbox.fetch_health()) {
    publish(*health, now_ns);
  }
  for (TrajectoryEvent event; mailbox.fetch(event);) {
    publish(event, now_ns);
  }
}

void Publisher::publish(const PublishedFrame& frame, std::int64_t now_ns) {
  Impl& self = *impl_;
  self.outbox.refill(now_ns);
  const CameraMotion motion = self.motion_meter.update(frame);
  self.frames.fetch_add(1, kRelaxed);
  if (!self.session) {
    self.frames_without_link.fetch_add(1, kRelaxed);
    return;
  }
  self.session->for_each([&](auto& topics) { topics.publish(frame, motion, self.outbox); });
  if (self.session->native) {
    self.session->native->publish_points(frame, self.outbox);
  }
  if (self.session->ros) {
    self.session->ros->publish_drawings(frame, self.outbox);
  }
}

void Publisher::publish(const PublishedHealth& health, std::int64_t now_ns) {
  Impl& self = *impl_;
  self.outbox.refill(now_ns);
  const bool is_due = !self.next_health_ns || now_ns >= *self.next_health_ns || health.state != self.told_state;
  if (!self.session || !is_due) {
    return;
  }
  self.next_health_ns = now_ns + kHealthEvery_ns;
  self.told_state = health.state;
  const PublishCounters sent = counters();
  self.session->for_each([&](const auto& topics) { topics.publish(health, sent, self.outbox); });
}

void Publisher::publish(const TrajectoryEvent& event, std::int64_t now_ns) {
  Impl& self = *impl_;
  self.outbox.refill(now_ns);
  self.buffers.trajectories.add(event, [&self](const TrajectoryPart& part) {
    if (self.session) {
      self.session->for_each([&](const auto& topics) { topics.publish(part, self.outbox); });
    }
  });
}

std::optional<std::string> Publisher::take_notice() {
  if (impl_->notice) {
    return std::exchange(impl_->notice, std::nullopt);
  }
  std::optional<std::string> line = impl_->log->take();
  return line ? "DDS: " + *line : line;
}

LinkState Publisher::state() const noexcept {
  return impl_->state;
}

PublishCounters Publisher::counters() const noexcept {
  const Impl& self = *impl_;
  PublishCounters counters;
  self.outbox.count_into(counters);
  counters.frames = self.frames.load(kRelaxed);
  counters.frames_without_link = self.frames_without_link.load(kRelaxed);
  counters.participant_restarts = self.restarts.load(kRelaxed);
  counters.log_lines = self.log->lines();
  counters.log_lines_suppressed = self.log->suppressed();
  return counters;
}

}  // namespace kinetrace::publishing
