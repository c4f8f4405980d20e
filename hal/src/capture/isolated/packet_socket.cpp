#include "capture/isolated/packet_socket.hpp"

#include <algorithm>
#include <cerrno>
#include <sys/socket.h>
#include <system_error>

#include "capture/frame_wait.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

/// Space for the descriptors of a packet.
struct alignas(cmsghdr) ControlBytes {
  std::array<char, CMSG_SPACE(kMaxDescriptors * sizeof(int))> bytes{};
};

iovec as_iovec(std::span<const std::byte> packet) noexcept {
  return {const_cast<std::byte*>(packet.data()), packet.size()};
}

void take_descriptors(msghdr& message, PacketSize& got) noexcept {
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS) {
      continue;
    }
    const std::size_t count = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < std::min(count, kMaxDescriptors); ++i) {
      int descriptor = -1;
      std::memcpy(&descriptor, CMSG_DATA(header) + i * sizeof descriptor, sizeof descriptor);
      got.descriptors[i] = OwnedFd(descriptor);
    }
  }
}

}  // namespace

Result<std::pair<PacketSocket, PacketSocket>> PacketSocket::make_pair() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return fail(ErrorCode::kIo, "a local socket: " + std::generic_category().message(errno));
  }
  return std::pair{PacketSocket(OwnedFd(ends[0])), PacketSocket(OwnedFd(ends[1]))};
}

bool PacketSocket::send(std::span<const std::byte> packet, std::span<const int> descriptors) const noexcept {
  ControlBytes control;
  iovec content = as_iovec(packet);
  msghdr message{};
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  if (!descriptors.empty()) {
    message.msg_control = control.bytes.data();
    message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(header), descriptors.data(), descriptors.size_bytes());
  }
  return sendmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(packet.size());
}

std::optional<PacketSize> PacketSocket::receive(std::span<std::byte> room,
                                                std::chrono::milliseconds timeout) const noexcept {
  if (!wait_readable(socket_.get(), timeout)) {
    return std::nullopt;
  }
  ControlBytes control;
  iovec content = as_iovec(room);
  msghdr message{};
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes.data();
  message.msg_controllen = control.bytes.size();
  PacketSize got;
  const ssize_t count = recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) {
    return std::nullopt;
  }
  // An error means the end, too: the other process died with unread packets.
  got.bytes = static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  take_descriptors(message, got);
  return got;
}

}  // namespace kinetrace::hal
