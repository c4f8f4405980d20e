// Starts the processes of an isolated capture backend.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <sys/types.h>

#include "capture/capture_backend.hpp"
#include "capture/isolated/packet_socket.hpp"

namespace kinetrace::hal {

/// A process of its own that serves one device; killed with its owner.
class IsolatedProcess {
 public:
  IsolatedProcess(PacketSocket calls, PacketSocket images, OwnedFd process) noexcept;
  IsolatedProcess(const IsolatedProcess&) = delete;
  IsolatedProcess& operator=(const IsolatedProcess&) = delete;
  /// Returns when it has ended and its devices are free.
  ~IsolatedProcess();

  /// The answer, which lies in `room` afterwards; empty where the process has ended, or did not answer in time.
  [[nodiscard]] std::span<const std::byte> call(const PacketWriter& packet, std::span<std::byte> room) const;
  [[nodiscard]] const PacketSocket& images() const noexcept { return images_; }

 private:
  PacketSocket calls_;
  PacketSocket images_;
  OwnedFd process_;
};

/// A small process, forked at once, from which all others are: a program with threads may not fork safely, and what it
/// has opened by then is no business of theirs. Ends with its owner, and with the program however that ends.
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
