#include "kinetrace/publishing/link.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <utility>

#include "config/domain_config.hpp"
#include "config/refusal.hpp"
#include "config/security_files.hpp"
#include "link/log_sink.hpp"
#include "link/network_interface.hpp"
#include "link/participant.hpp"

namespace kinetrace::publishing {
namespace {

std::int64_t system_time_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string waits_for(const std::string& interface) {
  return "DDS waits: interface " + interface + " is not there or has no address (there are " + interface_names() + ")";
}

}  // namespace

struct Link::Impl {
  PublishConfig config;
  std::string own_xml;  ///< Empty: the configuration is generated from the keys.
  std::unique_ptr<LogSink> log;
  // Independent of participants, so that they outlive each of them. They keep the library initialized, so that it
  // tolerates stale handles.
  Entity waitset;
  Entity alarm;
  std::optional<InterfaceAddress> address{};  ///< Address of the current participant.
  std::optional<std::int64_t> next_look_ns{};
  std::optional<std::int64_t> next_try_ns{};
  std::optional<std::string> notice{};
  std::optional<Participant> participant{};
  mutable std::mutex mutex{};  ///< Guards members that other threads read:
  LinkMembership membership{};
  std::uint64_t participants = 0;  ///< Number created so far.
  std::atomic<LinkState> state = LinkState::kWaiting;

  [[nodiscard]] bool has_own_xml() const noexcept { return !own_xml.empty(); }
  Status check_security() const;
  Status connect();
  void check_interface(std::int64_t now_ns);
  void disconnect(const std::string& why);
  void set(const LinkMembership& value) {
    const std::lock_guard lock(mutex);
    membership = value;
    participants = std::max(participants, value.number);
  }
};

Status Link::Impl::check_security() const {
  return config.security.mode == SecurityMode::kRequired ? check_security_files(config.security, system_time_s())
                                                         : Status{};
}

Status Link::Impl::connect() {
  // Checked at every start of a participant: certificates expire.
  if (Status secure = check_security(); !secure) {
    return secure;
  }
  const std::string xml = has_own_xml() ? own_xml : domain_xml(config, address && address->multicast);
  Result<Participant> made = Participant::create(config.domain, xml, address, *log);
  if (!made) {
    return Unexpected(publishing::explained(config, made.error()));
  }
  participant = std::move(*made);
  set({participants + 1, participant->get()});
  state = LinkState::kConnected;
  return {};
}

void Link::Impl::disconnect(const std::string& why) {
  set({});
  participant.reset();
  state = LinkState::kWaiting;
  notice = why;
}

// The interface of the user's own configuration is unknown.
void Link::Impl::check_interface(std::int64_t now_ns) {
  if (has_own_xml() || (next_look_ns && now_ns < *next_look_ns)) {
    return;
  }
  next_look_ns = now_ns + kLookEvery_ns;
  const std::optional<InterfaceAddress> found = find_interface(config.interface);
  if (found == address) {
    return;
  }
  address = found;
  next_try_ns = now_ns;
  disconnect(found ? "DDS restarts: interface " + config.interface + " has address " + found->ipv4
                   : waits_for(config.interface));
}

Link::Link(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Link::~Link() = default;

Result<std::unique_ptr<Link>> Link::create(const PublishConfig& config) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  std::string own_xml;
  if (!config.xml.empty()) {
    Result<std::string> read = read_own_xml(config);
    if (!read) {
      return Unexpected(read.error());
    }
    own_xml = std::move(*read);
  }
  auto log = LogSink::create(config.log_lines_per_minute);
  if (!log) {
    return Unexpected(log.error());
  }
  const ForeignCall foreign;
  std::unique_ptr<Impl> impl(new Impl{.config = config,
                                      .own_xml = std::move(own_xml),
                                      .log = std::move(*log),
                                      .waitset = Entity(dds_create_waitset(DDS_CYCLONEDDS_HANDLE)),
                                      .alarm = Entity(dds_create_guardcondition(DDS_CYCLONEDDS_HANDLE))});
  if (dds_waitset_attach(impl->waitset.get(), impl->alarm.get(), 0) != DDS_RETCODE_OK) {
    return fail(ErrorCode::kInternal, "the DDS library gives nothing to wait for messages with");
  }
  impl->address = impl->has_own_xml() ? std::nullopt : find_interface(config.interface);
  if (impl->address || impl->has_own_xml()) {
    if (const Status connected = impl->connect(); !connected) {
      return Unexpected(connected.error());
    }
  } else {
    if (const Status secure = impl->check_security(); !secure) {
      return Unexpected(secure.error());
    }
    impl->disconnect(waits_for(config.interface));
  }
  return std::unique_ptr<Link>(new Link(std::move(impl)));
}

void Link::supervise(std::int64_t now_ns) {
  Impl& self = *impl_;
  self.log->tick(now_ns);
  self.check_interface(now_ns);
  if (self.participant || !self.address || (self.next_try_ns && now_ns < *self.next_try_ns)) {
    return;
  }
  if (const Status connected = self.connect(); !connected) {
    self.state = LinkState::kFailed;
    self.notice = "DDS failed, tried again in a few seconds: " + connected.error().message;
    self.next_try_ns = now_ns + kRetryEvery_ns;
  }
}

std::optional<std::string> Link::take_notice() {
  if (impl_->notice) {
    return std::exchange(impl_->notice, std::nullopt);
  }
  std::optional<std::string> line = impl_->log->take();
  return line ? "DDS: " + *line : line;
}

Error Link::explained(const Error& error) const {
  return publishing::explained(impl_->config, error);
}

void Link::wait(std::int64_t at_most_ns) noexcept {
  const ForeignCall foreign;
  static_cast<void>(dds_waitset_wait(impl_->waitset.get(), nullptr, 0, at_most_ns));
  bool was_woken = false;
  static_cast<void>(dds_take_guardcondition(impl_->alarm.get(), &was_woken));
}

void Link::wake() noexcept {
  const ForeignCall foreign;
  static_cast<void>(dds_set_guardcondition(impl_->alarm.get(), true));
}

LinkMembership Link::membership() const noexcept {
  const std::lock_guard lock(impl_->mutex);
  return impl_->membership;
}

std::int32_t Link::waitset() const noexcept {
  return impl_->waitset.get();
}

LinkState Link::state() const noexcept {
  return impl_->state;
}

std::size_t Link::others() const {
  const ForeignCall foreign;
  constexpr std::size_t kMax = 64;
  std::array<void*, kMax> received{};
  std::array<dds_sample_info_t, kMax> infos{};
  const Entity reader(dds_create_reader(membership().participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  const dds_return_t count = reader.exists() ? dds_read(reader.get(), received.data(), infos.data(), kMax, kMax) : 0;
  const auto alive = std::count_if(infos.begin(), infos.begin() + std::max(count, 0),
                                   [](const auto& info) { return info.instance_state == DDS_ALIVE_INSTANCE_STATE; });
  if (count > 0) {
    static_cast<void>(dds_return_loan(reader.get(), received.data(), count));
  }
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(alive - 1, 0));  // Without ourselves.
}

std::uint64_t Link::restarts() const noexcept {
  const std::lock_guard lock(impl_->mutex);
  return impl_->participants == 0 ? 0 : impl_->participants - 1;
}

std::uint64_t Link::log_lines() const noexcept {
  return impl_->log->lines();
}

std::uint64_t Link::log_lines_suppressed() const noexcept {
  return impl_->log->suppressed();
}

}  // namespace kinetrace::publishing
