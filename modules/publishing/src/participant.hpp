// The membership in a DDS domain: what both publishing and reading need first.
#pragma once

#include <string>

#include "dds_entity.hpp"
#include "kinetrace/core/result.hpp"
#include "log_sink.hpp"

namespace kinetrace::publishing {

/// A domain with a configuration of its own, and a participant in it. While it exists nobody else in the process can
/// use the domain with another configuration.
class Participant {
 public:
  Participant() = default;

  /// Errors: kInvalidConfig where the library refuses the configuration, kIo where it refuses the participant; with
  /// what the library has logged about it.
  [[nodiscard]] static Result<Participant> create(int domain, const std::string& xml, LogSink& log);

  [[nodiscard]] dds_entity_t get() const noexcept { return participant_.get(); }

 private:
  Entity domain_;
  Entity participant_;  // After the domain, so that it goes first.
};

}  // namespace kinetrace::publishing
