#include "parts.hpp"

#include <stdexcept>

namespace kinetrace::test {
namespace {

Command joined(Command first, const Command& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

}  // namespace

Command kinetrace_command(const Command& more) {
  return joined({KINETRACE_PROGRAM}, more);
}

Command scene_command(const Command& more) {
  return joined({KINETRACE_PUBLISH_SCENE}, more);
}

Command fast_reader_command(const Command& more) {
  return joined({KINETRACE_FAST_READER}, more);
}

Command local_fast_reader_command(const Command& more) {
  return joined(fast_reader_command({"--peer", "127.0.0.1"}), more);
}

Command native_reader_command() {
  return {KINETRACE_NATIVE_READER};
}

void make_keys(const std::filesystem::path& folder, const Command& more) {
  const Ending ending = run_to_end(joined(kinetrace_command({"keys", "--out", folder.string()}), more));
  if (ending.exit_code != 0) {
    throw std::runtime_error("kinetrace keys: " + ending.err);
  }
}

std::filesystem::path enclave(const std::filesystem::path& keys, const std::string& name) {
  return keys / "enclaves" / name;
}

Command secured_by(const std::filesystem::path& enclave) {
  Command settings{"dds.security.mode=required"};
  for (const auto& [key, file] : {std::pair{"identity_ca", "identity_ca.cert.pem"},
                                  {"certificate", "cert.pem"},
                                  {"private_key", "key.pem"},
                                  {"permissions_ca", "permissions_ca.cert.pem"},
                                  {"governance", "governance.p7s"},
                                  {"permissions", "permissions.p7s"}}) {
    settings.push_back(std::string("dds.security.") + key + "=" + (enclave / file).string());
  }
  return settings;
}

Process::Condition all_topics_have(std::int64_t samples) {
  return [samples](const nlohmann::json& report) {
    for (const nlohmann::json& count : report.at("samples")) {
      if (count.get<std::int64_t>() < samples) {
        return false;
      }
    }
    return !report.at("samples").empty();
  };
}

Process::Condition more_than_now(const Process& process, const std::string& name, std::int64_t more) {
  const nlohmann::json now = process.report();
  return at_least(name, (now.is_null() ? 0 : now.at(name).get<std::int64_t>()) + more);
}

}  // namespace kinetrace::test
