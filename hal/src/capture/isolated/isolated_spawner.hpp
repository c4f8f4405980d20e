// Starts the processes of an isolated capture backend.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <sys/types.h>

#include "capture/capture_backend.hpp"
#include "capture/isolated/packet_socket.hpp"

namespace kinetrace::hal {

/// A process that serves one device; killed with its owner.
class IsolatedProcess {
 public:
  IsolatedProcess(PacketSocket calls, PacketSocket images, OwnedFd process) noexcept;
  IsolatedProcess(const IsolatedProcess&) = delete;
  IsolatedProcess& operator=(const IsolatedProcess&) = delete;
  /// Waits until the process has ended and its devices are free.
  ~IsolatedProcess();

  /// The answer, stored in `room`; empty if the process has ended or did not answer in time.
  [[nodiscard]] std::span<const std::byte> call(const PacketWriter& packet, std::span<std::byte> room) const;
  [[nodiscard]] const PacketSocket& images() const noexcept { return images_; }

 private:
  PacketSocket calls_;
  PacketSocket images_;
  OwnedFd process_;
};

/// A small process, forked early, that forks all others: a program with threads cannot fork safely, and the others must
/// not inherit its open files. Ends with its owner, and with the program even if that crashes.
class IsolatedSpawner {
 public:
  /// Errors: kIo.
  [[nodiscard]] static Result<std::shared_ptr<IsolatedSpawner>> start(const CaptureBackendEntry& backend);
  IsolatedSpawner(PacketSocket orders, pid_t process) noexcept : orders_(std::move(orders)), process_(process) {}
  IsolatedSpawner(const IsolatedSpawner&) = delete;
  IsolatedSpawner& operator=(const IsolatedSpawner&) = delete;
  ~IsolatedSpawner();

  /// Errors: kIo.
  [[nodiscard]] Result<std::unique_ptr<IsolatedProcess>> spawn() const;

 private:
  PacketSocket orders_;
  pid_t process_;
};

}  // namespace kinetrace::hal
