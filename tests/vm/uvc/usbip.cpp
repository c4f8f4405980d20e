#include "usbip.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <unistd.h>

namespace kinetrace::hal::test {
namespace {

constexpr std::uint32_t kCommandSubmit = 1;
constexpr std::uint32_t kCommandUnlink = 2;
constexpr std::uint32_t kReplySubmit = 3;
constexpr std::uint32_t kReplyUnlink = 4;

// A header is twelve big-endian words; those of a request end with the eight bytes of the setup packet.
constexpr std::size_t kWords = 12;
using Header = std::array<std::uint32_t, kWords>;
enum Word : std::uint8_t { kCommand, kSequence, kDevice, kDirection, kEndpoint, kFirstOfCommand };
constexpr std::size_t kLength = kFirstOfCommand + 1;
constexpr std::size_t kSetup = 10;
constexpr std::uint32_t kIn = 1;

bool receive_all(int socket, void* target, std::size_t bytes) {
  auto* place = static_cast<std::uint8_t*>(target);
  while (bytes > 0) {
    const ssize_t got = recv(socket, place, bytes, 0);
    if (got <= 0) {
      return false;
    }
    place += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

bool send_all(int socket, const void* source, std::size_t bytes) {
  const auto* place = static_cast<const std::uint8_t*>(source);
  while (bytes > 0) {
    const ssize_t sent = ::send(socket, place, bytes, MSG_NOSIGNAL);
    if (sent <= 0) {
      return false;
    }
    place += sent;
    bytes -= static_cast<std::size_t>(sent);
  }
  return true;
}

}  // namespace

UsbipConnection::~UsbipConnection() {
  ::close(socket_);
}

void UsbipConnection::shut_down() {
  ::shutdown(socket_, SHUT_RDWR);
}

std::optional<UsbipRequest> UsbipConnection::receive() {
  Header header{};
  if (!receive_all(socket_, header.data(), sizeof header)) {
    return std::nullopt;
  }
  UsbipRequest request;
  std::memcpy(request.setup.data(), &header[kSetup], request.setup.size());
  std::transform(header.begin(), header.end(), header.begin(), [](std::uint32_t word) { return ntohl(word); });
  request.sequence = header[kSequence];
  request.endpoint = header[kEndpoint];
  if (header[kCommand] == kCommandUnlink) {
    request.kind = UsbipRequest::Kind::kUnlink;
    request.unlinked_sequence = header[kFirstOfCommand];
    return request;
  }
  if (header[kCommand] != kCommandSubmit) {
    return std::nullopt;
  }
  request.length = header[kLength];
  if (header[kDirection] != kIn && request.length > 0) {
    request.sent.resize(request.length);
    if (!receive_all(socket_, request.sent.data(), request.sent.size())) {
      return std::nullopt;
    }
  }
  return request;
}

void UsbipConnection::reply(std::uint32_t sequence, int status, std::span<const std::uint8_t> data,
                            std::uint32_t taken) {
  Header header{};
  header[kCommand] = kReplySubmit;
  header[kSequence] = sequence;
  header[kFirstOfCommand] = static_cast<std::uint32_t>(status);
  header[kLength] = data.empty() ? taken : static_cast<std::uint32_t>(data.size());
  send(header, data);
}

void UsbipConnection::reply_unlink(std::uint32_t sequence, bool found) {
  Header header{};
  header[kCommand] = kReplyUnlink;
  header[kSequence] = sequence;
  header[kFirstOfCommand] = static_cast<std::uint32_t>(found ? -ECONNRESET : 0);
  send(header, {});
}

void UsbipConnection::send(std::span<const std::uint32_t> words, std::span<const std::uint8_t> data) {
  Header wire{};
  std::transform(words.begin(), words.end(), wire.begin(), [](std::uint32_t word) { return htonl(word); });
  const std::lock_guard lock(sending_);
  // receive() notices an ended connection.
  if (send_all(socket_, wire.data(), sizeof wire)) {
    send_all(socket_, data.data(), data.size());
  }
}

}  // namespace kinetrace::hal::test
