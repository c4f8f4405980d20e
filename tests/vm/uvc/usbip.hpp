// The messages of the kernel's USB/IP protocol (Documentation/usb/usbip_protocol), device side.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace kinetrace::hal::test {

struct UsbipRequest {
  enum class Kind : std::uint8_t { kSubmit, kUnlink };
  Kind kind = Kind::kSubmit;
  std::uint32_t sequence = 0;
  std::uint32_t endpoint = 0;
  std::uint32_t length = 0;             ///< Bytes the host sends or has room for.
  std::array<std::uint8_t, 8> setup{};  ///< Endpoint 0.
  std::vector<std::uint8_t> sent;       ///< Data from the host.
  std::uint32_t unlinked_sequence = 0;  ///< To unlink: the sequence of an earlier request.
};

/// One end of a stream socket; the other belongs to the kernel. One thread receives, any thread may reply.
class UsbipConnection {
 public:
  /// Takes ownership of the descriptor.
  explicit UsbipConnection(int socket) : socket_(socket) {}
  UsbipConnection(const UsbipConnection&) = delete;
  UsbipConnection& operator=(const UsbipConnection&) = delete;
  ~UsbipConnection();

  /// None once the connection has ended.
  [[nodiscard]] std::optional<UsbipRequest> receive();
  /// `status` 0 or a negative errno; `data` for requests that read, `taken` bytes of one that wrote.
  void reply(std::uint32_t sequence, int status, std::span<const std::uint8_t> data, std::uint32_t taken = 0);
  /// `found`: the request to unlink was still waiting and will not be replied to.
  void reply_unlink(std::uint32_t sequence, bool found);
  /// Ends receive().
  void shut_down();

 private:
  void send(std::span<const std::uint32_t> words, std::span<const std::uint8_t> data);

  int socket_;
  std::mutex sending_;
};

}  // namespace kinetrace::hal::test
