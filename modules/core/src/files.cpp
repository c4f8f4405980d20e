#include "kinetrace/core/files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include "kinetrace/core/input_file.hpp"

namespace kinetrace {
namespace {

namespace fs = std::filesystem;

class Descriptor {
 public:
  explicit Descriptor(int value) noexcept : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) {
      ::close(value_);
    }
  }
  [[nodiscard]] int get() const noexcept { return value_; }
  [[nodiscard]] bool close() noexcept { return ::close(std::exchange(value_, -1)) == 0; }

 private:
  int value_;
};

std::string reason(int error_number) {
  return std::generic_category().message(error_number);
}

Unexpected<Error> not_written(const fs::path& path, int error_number) {
  const bool is_full = error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG;
  return fail(ErrorCode::kIo, path.string() + ": cannot be written (" + reason(error_number) + "); " +
                                  (is_full ? "free space" : "check the folder and its permissions"));
}

/// Returns 0 or the error number.
int write_all(int descriptor, std::string_view content) noexcept {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0 && errno != EINTR) {
      return errno;
    }
    content.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
  }
  return 0;
}

int write_whole(const fs::path& path, std::string_view content) {
  Descriptor file(open_staged(path));
  if (file.get() < 0) {
    return errno;
  }
  if (const int error = write_all(file.get(), content); error != 0) {
    return error;
  }
  // fsync fails on pipes and devices.
  if (::fsync(file.get()) != 0 && errno != EINVAL && errno != EROFS) {
    return errno;
  }
  return file.close() ? 0 : errno;
}

/// Follows links, so that replacing a linked file keeps the link.
fs::path target_of(const fs::path& path) {
  std::error_code error;
  const bool is_link = fs::is_symlink(path, error);
  const fs::path target = is_link ? fs::canonical(path, error) : path;
  return error ? path : target;
}

Unexpected<Error> obstructed(const fs::path& path, std::string_view what, const std::error_code& why) {
  const char* remedy = why == std::errc::filename_too_long               ? "; shorten it"
                       : why == std::errc::too_many_symbolic_link_levels ? "; check where its links lead"
                                                                         : "; check the permissions";
  return fail(ErrorCode::kIo,
              path.string().append(": ").append(what).append(" (" + why.message() + ")").append(remedy));
}

/// Kind of an existing entry that is not of the expected kind.
std::string_view other_kind(fs::file_type type) noexcept {
  switch (type) {
    case fs::file_type::regular: return "is a file; ";
    case fs::file_type::directory: return "is a folder; ";
    case fs::file_type::fifo: return "is a pipe; ";
    case fs::file_type::socket: return "is a socket; ";
    case fs::file_type::character:
    case fs::file_type::block: return "is a device; ";
    default: return "";
  }
}

}  // namespace

Unexpected<Error> unreachable(const fs::path& path, std::string_view missing) {
  std::error_code error;
  // A missing entry is reported as kNotFound below.
  const fs::file_status status = fs::status(path, error);
  if (error && error != std::errc::no_such_file_or_directory && error != std::errc::not_a_directory) {
    return obstructed(path, "cannot be reached", error);
  }
  return fail(ErrorCode::kNotFound, path.string().append(": ").append(other_kind(status.type())).append(missing));
}

Status check_folder(const fs::path& path, std::string_view missing) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return unreachable(path, missing);
  }
  const fs::directory_iterator names(path, error);
  return error ? Status(obstructed(path, "cannot be listed", error)) : Status{};
}

fs::path staged_path(const fs::path& path) {
  std::error_code error;
  fs::path target = target_of(path);
  const fs::file_status status = fs::status(target, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return target;
  }
  // Unique to the process: another one may be writing the same file.
  fs::path staged = target;
  staged += ".";
  staged += std::to_string(::getpid());
  staged += ".tmp";
  return staged;
}

int open_staged(const fs::path& staged) noexcept {
  // Without O_NONBLOCK, opening a pipe without a reader would block for ever.
  const int file = ::open(staged.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
  if (file >= 0) {
    (void)::fcntl(file, F_SETFL, 0);
  }
  return file;
}

Status put_in_place(const fs::path& staged, const fs::path& path) {
  const fs::path target = target_of(path);
  if (staged == target || ::rename(staged.c_str(), target.c_str()) == 0) {
    return {};
  }
  const int error_number = errno;
  discard_staged(staged, path);
  return not_written(path, error_number);
}

void discard_staged(const fs::path& staged, const fs::path& path) {
  if (staged != target_of(path)) {
    ::unlink(staged.c_str());
  }
}

Status check_replaceable(const fs::path& path) {
  const fs::path target = target_of(path);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code error;
  if (fs::is_directory(target, error)) {
    return not_written(path, EISDIR);
  }
  return ::access(folder.c_str(), W_OK | X_OK) == 0 ? Status{} : Status(not_written(path, errno));
}

Status check_same_kind(const fs::path& path, const FileKind& kind) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) == 0 || kind.is_of_kind(path)) {
    return {};
  }
  return fail(ErrorCode::kOccupied,
              path.string().append(": is there already, and is no ").append(kind.name).append("; name another place"));
}

bool begins_with(const fs::path& path, std::string_view text) {
  InPlaceResult<InputFile> file = InputFile::open(path.c_str());
  std::vector<std::uint8_t> begin(text.size());
  return file && file->read(0, begin) == begin.size() && std::memcmp(begin.data(), text.data(), text.size()) == 0;
}

bool is_inside(const fs::path& path, const fs::path& folder) {
  std::error_code error;
  const fs::path inner = fs::weakly_canonical(fs::absolute(path, error), error);
  fs::path outer = fs::weakly_canonical(fs::absolute(folder, error), error);
  if (!outer.has_filename()) {
    outer = outer.parent_path();  // The name ended with a slash.
  }
  return !outer.empty() && std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

Status replace_file(const fs::path& path, std::string_view content) {
  const fs::path staged = staged_path(path);
  if (const int error_number = write_whole(staged, content); error_number != 0) {
    discard_staged(staged, path);
    return not_written(path, error_number);
  }
  if (Status placed = put_in_place(staged, path); !placed) {
    return placed;
  }
  // A rename is durable only once the folder is on disk.
  const fs::path folder = staged.has_parent_path() ? staged.parent_path() : fs::path(".");
  if (const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
      opened.get() >= 0 && ::fsync(opened.get()) != 0) {
    return errno == EINVAL ? Status{} : Status(not_written(path, errno));
  }
  return {};
}

}  // namespace kinetrace
