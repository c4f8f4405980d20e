#include "link/participant.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

#include "link/socket_filter.hpp"

namespace kinetrace::publishing {
namespace {

// If a new domain cannot open a socket, Cyclone DDS 0.10 tears down parts that it has not set up yet and crashes
// (rtps_fini). It needs half as many files.
Status check_free_files() {
  std::array<int, 12> files{};
  int count = 0;
  int error = 0;
  for (int& file : files) {
    file = open("/dev/null", O_RDONLY | O_CLOEXEC);
    error = file < 0 ? errno : error;
    count += file < 0 ? 0 : 1;
  }
  for (const int file : files) {
    if (file >= 0) {
      close(file);
    }
  }
  return error == 0 ? Status{}
                    : fail(ErrorCode::kIo, "DDS needs " + std::to_string(files.size()) + " open files, and only " +
                                               std::to_string(count) + " can be opened (" + std::strerror(error) +
                                               "); allow more (ulimit -n)");
}

}  // namespace

Result<Participant> Participant::create(int domain, const std::string& xml,
                                        const std::optional<InterfaceAddress>& interface, LogSink& log) {
  const ForeignCall foreign;
  static_cast<void>(log.take_reason());
  if (const Status free = check_free_files(); !free) {
    return Unexpected(free.error());
  }
  const auto id = static_cast<dds_domainid_t>(domain);
  Participant made;
  made.domain_ = Entity(dds_create_domain(id, xml.c_str()));
  if (!made.domain_.exists()) {
    const std::string reason = log.take_reason();
    return fail(ErrorCode::kInvalidConfig, "DDS domain " + std::to_string(domain) +
                                               " cannot be made: " + (reason.empty() ? made.domain_.error() : reason));
  }
  // The domain's sockets are open now.
  if (const Status confined = interface ? confine_sockets(domain, *interface) : Status{}; !confined) {
    return Unexpected(confined.error());
  }
  made.participant_ = Entity(dds_create_participant(id, nullptr, nullptr));
  if (!made.participant_.exists()) {
    const std::string reason = log.take_reason();
    return fail(ErrorCode::kIo, "no participant in DDS domain " + std::to_string(domain) + ": " +
                                    (reason.empty() ? made.participant_.error() : reason));
  }
  return made;
}

}  // namespace kinetrace::publishing
