// A group of processes with limits enforced by the kernel, for tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace kinetrace::test {

/// Exists as long as this object; its processes must have ended before. Supports both versions of control groups.
class ControlGroup {
 public:
  /// Limits memory, without swap; empty if this process may not make such a group.
  [[nodiscard]] static std::optional<ControlGroup> of_memory(std::uint64_t bytes) {
    if (auto v1 = make("memory", "memory.limit_in_bytes", std::to_string(bytes))) {
      return v1;
    }
    return make("", "memory.max", std::to_string(bytes));
  }
  /// Limits processor time to this percentage of one core, in slices so short that work is slowed rather than paused.
  [[nodiscard]] static std::optional<ControlGroup> of_processor(int percent) {
    constexpr int kPeriod_us = 10'000;
    const std::string quota_us = std::to_string(percent * kPeriod_us / 100);
    if (auto v1 = make("cpu", "cpu.cfs_quota_us", quota_us)) {
      write(v1->folder_ / "cpu.cfs_period_us", std::to_string(kPeriod_us));
      return v1;
    }
    return make("", "cpu.max", quota_us + " " + std::to_string(kPeriod_us));
  }
  ControlGroup(const ControlGroup&) = delete;
  ControlGroup& operator=(const ControlGroup&) = delete;
  ControlGroup(ControlGroup&& other) noexcept
      : folder_(std::exchange(other.folder_, {})), limit_(std::move(other.limit_)) {}
  ControlGroup& operator=(ControlGroup&&) = delete;
  ~ControlGroup() {
    if (!folder_.empty()) {
      std::error_code ignored;
      std::filesystem::remove(folder_, ignored);
    }
  }

  /// Lifts the processor limit.
  void release_processor() const { write(folder_ / limit_, limit_ == "cpu.max" ? "max" : "-1"); }
  /// A command line that joins the group and then executes `command`.
  [[nodiscard]] std::vector<std::string> around(const std::vector<std::string>& command) const {
    std::vector<std::string> all{"sh", "-c", "echo $$ > \"$0\" && exec \"$@\"", (folder_ / "cgroup.procs").string()};
    all.insert(all.end(), command.begin(), command.end());
    return all;
  }

 private:
  ControlGroup(std::filesystem::path folder, std::string limit)
      : folder_(std::move(folder)), limit_(std::move(limit)) {}
  static bool write(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text;
    out.close();
    return static_cast<bool>(out);
  }
  static std::optional<ControlGroup> make(const std::string& controller, const std::string& limit,
                                          const std::string& value) {
    const std::filesystem::path root = "/sys/fs/cgroup";
    const std::filesystem::path folder = root / controller / ("kinetrace-test-" + limit + std::to_string(::getpid()));
    std::error_code failed;
    if (!std::filesystem::create_directory(folder, failed)) {
      return std::nullopt;
    }
    ControlGroup group(folder, limit);
    const bool has_limit = std::filesystem::exists(folder / limit, failed) && write(folder / limit, value);
    return has_limit ? std::optional<ControlGroup>(std::move(group)) : std::nullopt;
  }

  std::filesystem::path folder_;
  std::string limit_;
};

}  // namespace kinetrace::test
