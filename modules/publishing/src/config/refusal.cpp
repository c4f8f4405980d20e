#include "config/refusal.hpp"

#include <string>
#include <string_view>

namespace kinetrace::publishing {
namespace {

bool has(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

/// "config: //CycloneDDS/Domain: Genral: unknown element (CYCLONEDDS_URI+0 line 1)" without the prefix and the
/// variable: the library attributes any configuration to this variable.
std::string without_origin(const std::string& words) {
  constexpr std::string_view kPrefix = "config: ";
  constexpr std::string_view kVariable = "CYCLONEDDS_URI+0 ";
  const std::size_t prefix = words.find(kPrefix);
  std::string plain = prefix == std::string::npos ? words : words.substr(prefix + kPrefix.size());
  if (const std::size_t variable = plain.find(kVariable); variable != std::string::npos) {
    plain.erase(variable, kVariable.size());
  }
  return plain;
}

/// A document of DDS Security by its key and file.
std::string named(std::string_view key, const std::string& file) {
  return "dds.security." + std::string(key) + ": " + file;
}

Error refused_by_security(const SecurityConfig& config, const Error& error) {
  const std::string permissions = named("permissions", config.permissions);
  if (has(error.message, "Subject name is invalid")) {
    return {ErrorCode::kInvalidConfig, permissions + " must be for the subject of " + config.certificate +
                                           " (dds.security.certificate) and is for another one; use two that were "
                                           "made together"};
  }
  if (has(error.message, "Not Allowed By Security")) {
    return {ErrorCode::kInvalidConfig, permissions + " does not allow this: " + error.message +
                                           "; allow its topics there, or use files that `kinetrace keys` made for a "
                                           "machine that does this"};
  }
  const bool is_governance = has(error.message, "governance");
  return {ErrorCode::kInvalidConfig, (is_governance ? named("governance", config.governance) : permissions) +
                                         " is refused: " + error.message +
                                         "; correct and sign it again, or make new files with `kinetrace keys`"};
}

}  // namespace

Error explained(const PublishConfig& config, const Error& error) {
  if (!config.xml.empty() && has(error.message, "CYCLONEDDS_URI")) {
    return {ErrorCode::kInvalidConfig, "dds.xml: " + config.xml + " is refused by the DDS library: " +
                                           without_origin(error.message) + "; correct it there"};
  }
  const bool is_security = has(error.message, "Not Allowed By Security") || has(error.message, "(code: 1");
  return config.security.mode == SecurityMode::kRequired && is_security ? refused_by_security(config.security, error)
                                                                        : error;
}

}  // namespace kinetrace::publishing
