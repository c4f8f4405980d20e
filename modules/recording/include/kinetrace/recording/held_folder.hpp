// Reserves a run folder before there is anything to write.
#pragma once

#include <filesystem>
#include <memory>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::recording {

/// A run folder held for a run that is written at the end of long work: meanwhile other runs are refused. A folder that
/// did not exist is made, and removed again by the destructor if it is still empty.
class KINETRACE_API HeldFolder {
 public:
  /// Errors: as RunRecorder::create.
  [[nodiscard]] static Result<HeldFolder> take(const std::filesystem::path& directory);

  HeldFolder(HeldFolder&&) noexcept;
  HeldFolder& operator=(HeldFolder&&) = delete;
  ~HeldFolder();

  /// Lets go of the folder, for the RunRecorder that takes it next.
  void release() noexcept;

 private:
  struct Impl;
  explicit HeldFolder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::recording
