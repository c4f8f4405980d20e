#include "participant.hpp"

#include <utility>

#include "socket_filter.hpp"

namespace kinetrace::publishing {

Result<Participant> Participant::create(int domain, const std::string& xml,
                                        const std::optional<InterfaceAddress>& interface, LogSink& log) {
  const ForeignCall foreign;
  static_cast<void>(log.take_reason());
  const auto id = static_cast<dds_domainid_t>(domain);
  Participant made;
  made.domain_ = Entity(dds_create_domain(id, xml.c_str()));
  if (!made.domain_.exists()) {
    const std::string reason = log.take_reason();
    return fail(ErrorCode::kInvalidConfig, "DDS domain " + std::to_string(domain) +
                                               " cannot be made: " + (reason.empty() ? made.domain_.error() : reason));
  }
  // The domain has opened its sockets.
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
