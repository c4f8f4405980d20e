// Owners of handles of Cyclone DDS's C interface.
#pragma once

#include <memory>
#include <utility>

#include <dds/dds.h>

#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::publishing {

/// A DDS entity, deleted with all its children.
class Entity {
 public:
  Entity() = default;
  /// Takes the result of a dds_create_ function; a negative value is an error and owns nothing.
  explicit Entity(dds_entity_t handle) noexcept : handle_(handle) {}
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() {
    if (handle_ > 0) {
      const ForeignCall foreign;
      static_cast<void>(dds_delete(handle_));
    }
  }

  [[nodiscard]] bool exists() const noexcept { return handle_ > 0; }
  [[nodiscard]] dds_entity_t get() const noexcept { return handle_; }
  /// Reason for a missing entity.
  [[nodiscard]] const char* error() const noexcept { return dds_strretcode(-handle_); }

 private:
  dds_entity_t handle_ = 0;
};

struct QosDeleter {
  void operator()(dds_qos_t* qos) const noexcept { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

}  // namespace kinetrace::publishing
