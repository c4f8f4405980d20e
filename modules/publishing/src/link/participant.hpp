// Membership in a DDS domain, the basis of readers and writers.
#pragma once

#include <optional>
#include <string>

#include "kinetrace/core/result.hpp"
#include "link/dds_entity.hpp"
#include "link/log_sink.hpp"
#include "link/network_interface.hpp"

namespace kinetrace::publishing {

/// A domain with a configuration of its own, and a participant in it. While it exists, the process cannot use the
/// domain with another configuration.
class Participant {
 public:
  Participant() = default;

  /// Receives by `interface` only; without one, by any. Errors, with the library's log line: kInvalidConfig
  /// (configuration refused), kIo (participant refused).
  [[nodiscard]] static Result<Participant> create(int domain, const std::string& xml,
                                                  const std::optional<InterfaceAddress>& interface, LogSink& log);

  [[nodiscard]] dds_entity_t get() const noexcept { return participant_.get(); }

 private:
  Entity domain_;
  Entity participant_;  // Declared after the domain, so that it is destroyed first.
};

}  // namespace kinetrace::publishing
