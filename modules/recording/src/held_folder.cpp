#include "kinetrace/recording/held_folder.hpp"

#include <system_error>
#include <utility>

#include "folder_lock.hpp"
#include "run_folder.hpp"

namespace kinetrace::recording {

struct HeldFolder::Impl {
  FolderLock lock;
  std::filesystem::path made;  ///< Empty if it existed before.

  ~Impl() {
    std::error_code not_empty;
    if (!made.empty()) {
      std::filesystem::remove(made, not_empty);
    }
  }
};

HeldFolder::HeldFolder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HeldFolder::HeldFolder(HeldFolder&&) noexcept = default;
HeldFolder::~HeldFolder() = default;

Result<HeldFolder> HeldFolder::take(const std::filesystem::path& directory) {
  if (const Status usable = check_run_folder(directory); !usable) {
    return Unexpected(usable.error());
  }
  auto impl = std::make_unique<Impl>();
  std::error_code error;
  if (std::filesystem::create_directories(directory, error)) {
    impl->made = directory;
  }
  if (error) {
    return file_error("create", directory, error.value());
  }
  impl->lock = FolderLock::take(directory, FolderUse::kWrite);
  if (impl->lock.is_refused()) {
    impl->made.clear();
    return fail(ErrorCode::kInvalidArgument, "cannot record to " + directory.string() +
                                                 ": another run has just begun to use it; name another folder");
  }
  return HeldFolder(std::move(impl));
}

void HeldFolder::release() noexcept {
  impl_->lock = FolderLock();
}

}  // namespace kinetrace::recording
