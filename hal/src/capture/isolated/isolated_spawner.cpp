#include "capture/isolated/isolated_spawner.hpp"

#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include "capture/frame_wait.hpp"
#include "capture/isolated/isolated_worker.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// Starting a camera is slow in some libraries, and slower on a loaded machine.
constexpr std::chrono::milliseconds kMaxAnswer{10'000};
constexpr std::chrono::milliseconds kMaxEnd{2000};
constexpr std::chrono::milliseconds kLong = std::chrono::hours(24);
constexpr std::byte kOrder{1};

Unexpected<Error> failure_of(const char* what) {
  return fail(ErrorCode::kIo, concat("a process for cameras: ", what, ": ", std::generic_category().message(errno)));
}

int open_process(pid_t process) {
  return static_cast<int>(syscall(SYS_pidfd_open, process, 0));
}

/// Closes the program's files and ignores the terminal's signals: only the socket ends this process.
void detach(int kept_descriptor) {
  prctl(PR_SET_NAME, "kinetrace-camera");
  constexpr int kSocket = 3;
  if (kept_descriptor != kSocket) {
    dup2(kept_descriptor, kSocket);
  }
  close_range(kSocket + 1, ~0U, 0);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO}) {
    dup2(nothing, stream);
  }
  fcntl(kSocket, F_SETFD, FD_CLOEXEC);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) {
    std::signal(number, SIG_IGN);
  }
  for (const int number : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) {
    std::signal(number, SIG_DFL);
  }
}

void serve_fork_requests(const CaptureBackendEntry& backend, const PacketSocket& orders) {
  std::byte order{};
  for (;;) {
    auto got = orders.receive(std::span(&order, 1), kLong);
    if (!got) {
      continue;
    }
    if (got->bytes == 0) {
      return;
    }
    PacketSocket calls(std::move(got->descriptors[0]));
    PacketSocket images(std::move(got->descriptors[1]));
    const pid_t parent = getpid();
    const pid_t process = fork();
    if (process == 0) {
      // Dies with its parent even if a foreign library hangs.
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) {
        return;
      }
      close(orders.fd());
      serve_device(backend, std::move(calls), std::move(images));
    }
    const OwnedFd handle(process < 0 ? -1 : open_process(process));
    const int descriptor = handle.get();
    static_cast<void>(orders.send(std::span(&kOrder, 1), std::span(&descriptor, handle.valid() ? 1 : 0)));
  }
}

}  // namespace

IsolatedProcess::IsolatedProcess(PacketSocket calls, PacketSocket images, OwnedFd process) noexcept
    : calls_(std::move(calls)), images_(std::move(images)), process_(std::move(process)) {}

IsolatedProcess::~IsolatedProcess() {
  syscall(SYS_pidfd_send_signal, process_.get(), SIGKILL, nullptr, 0);
  wait_readable(process_.get(), kMaxEnd);
}

std::span<const std::byte> IsolatedProcess::call(const PacketWriter& packet, std::span<std::byte> room) const {
  if (!calls_.send(packet.bytes())) {
    return {};
  }
  const auto got = calls_.receive(room, kMaxAnswer);
  return room.first(got ? got->bytes : 0);
}

Result<std::shared_ptr<IsolatedSpawner>> IsolatedSpawner::start(const CaptureBackendEntry& backend) {
  auto ends = PacketSocket::make_pair();
  if (!ends) {
    return Unexpected(ends.error());
  }
  const pid_t process = fork();
  if (process < 0) {
    return failure_of("fork");
  }
  if (process == 0) {
    detach(ends->second.fd());
    constexpr int kSocket = 3;
    serve_fork_requests(backend, PacketSocket(OwnedFd(kSocket)));
    _exit(0);
  }
  return std::make_shared<IsolatedSpawner>(std::move(ends->first), process);
}

IsolatedSpawner::~IsolatedSpawner() {
  orders_ = PacketSocket();
  waitpid(process_, nullptr, 0);
}

Result<std::unique_ptr<IsolatedProcess>> IsolatedSpawner::spawn() const {
  auto calls = PacketSocket::make_pair();
  auto images = PacketSocket::make_pair();
  if (!calls || !images) {
    return failure_of("local sockets");
  }
  const std::array<int, 2> theirs{calls->second.fd(), images->second.fd()};
  std::byte answer{};
  if (!orders_.send(std::span(&kOrder, 1), theirs)) {
    return fail(ErrorCode::kIo, "the process that starts cameras has ended; start the program again");
  }
  auto got = orders_.receive(std::span(&answer, 1), kMaxAnswer);
  if (!got || !got->descriptors[0].valid()) {
    return fail(ErrorCode::kIo, "no process for a camera could be started; is the number of processes limited?");
  }
  return std::make_unique<IsolatedProcess>(std::move(calls->first), std::move(images->first),
                                           std::move(got->descriptors[0]));
}

}  // namespace kinetrace::hal
