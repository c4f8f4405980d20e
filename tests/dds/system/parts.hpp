// Command lines of the programs that tests combine, and common conditions on their reports.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "process.hpp"

namespace kinetrace::test {

using Command = std::vector<std::string>;

/// `kinetrace ...` itself.
[[nodiscard]] Command kinetrace_command(const Command& more);
/// Publishes the scene; `more` as in publish_scene.cpp.
[[nodiscard]] Command scene_command(const Command& more = {});
/// Reads all topics of ROS 2 with Fast DDS; `more` as in fast_reader.cpp.
[[nodiscard]] Command fast_reader_command(const Command& more = {});
/// As above, on the loopback.
[[nodiscard]] Command local_fast_reader_command(const Command& more = {});
/// Reads all of Kinetrace's own topics on the loopback.
[[nodiscard]] Command native_reader_command();

/// Makes keys with `kinetrace keys`; throws on failure.
void make_keys(const std::filesystem::path& folder, const Command& more = {});
/// A participant's folder of keys.
[[nodiscard]] std::filesystem::path enclave(const std::filesystem::path& keys, const std::string& name);
/// Settings for scene_command: security with the files of an enclave.
[[nodiscard]] Command secured_by(const std::filesystem::path& enclave);

/// Condition: every topic has at least this many samples.
[[nodiscard]] Process::Condition all_topics_have(std::int64_t samples);
/// Condition: `name` has grown by `more` since the call.
[[nodiscard]] Process::Condition more_than_now(const Process& process, const std::string& name, std::int64_t more);

}  // namespace kinetrace::test
