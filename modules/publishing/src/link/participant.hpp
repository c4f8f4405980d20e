// The membership in a DDS domain: what both publishing and reading need first.
#pragma once

#include <optional>
#include <string>

#include "kinetrace/core/result.hpp"
#include "link/dds_entity.hpp"
#include "link/log_sink.hpp"
#include "link/network_interface.hpp"

namespace kinetrace::publishing {

/// A domain with a configuration of its own, and a participant in it. While it exists nobody else in the process can
/// use the domain with another configuration.
class Participant {
 public:
  Participant() = default;

  /// Nothing is received but by `interface`; by any where there is none. Errors: kInvalidConfig where the library
  /// refuses the configuration, kIo where it refuses the participant; with what the library has logged about it.
  [[nodiscard]] static Result<Participant> create(int domain, const std::string& xml,
                                                  const std::optional<InterfaceAddress>& interface, LogSink& log);

  [[nodiscard]] dds_entity_t get() const noexcept { return participant_.get(); }

 private:
  Entity domain_;
  Entity participant_;  // After the domain, so that it goes first.
};

}  // namespace kinetrace::publishing
