#include "config/domain_config.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "config/security_files.hpp"
#include "kinetrace/core/files.hpp"

namespace kinetrace::publishing {
namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string element(std::string_view name, std::string_view text) {
  const std::string tag(name);
  return "<" + tag + ">" + escaped(text) + "</" + tag + ">";
}

bool is_loopback(const PublishConfig& config) {
  return config.interface == "lo";
}

std::string general(const PublishConfig& config, bool has_multicast) {
  const bool is_silent = !has_multicast || is_loopback(config) || config.multicast == Multicast::kOff;
  const char* multicast = is_silent ? "false" : config.multicast == Multicast::kAll ? "true" : "spdp";
  return "<General><Interfaces><NetworkInterface name=\"" + escaped(config.interface) + "\" multicast=\"" +
         (is_silent ? "false" : "true") + "\"/></Interfaces>" + element("AllowMulticast", multicast) + "</General>";
}

std::string discovery(const PublishConfig& config) {
  // Without multicast, participants on a machine are found by trying the first few port numbers.
  constexpr const char* kAnnounceEvery = "5 s";
  std::string peers;
  std::istringstream list(config.peers + (is_loopback(config) ? ",127.0.0.1" : ""));
  for (std::string peer; std::getline(list, peer, ',');) {
    peers += peer.empty() ? "" : "<Peer address=\"" + escaped(peer) + "\"/>";
  }
  return "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>31</MaxAutoParticipantIndex>" +
         element("SPDPInterval", kAnnounceEvery) + (peers.empty() ? "" : "<Peers>" + peers + "</Peers>") +
         "</Discovery>";
}

// Received traffic is small: acknowledgements and requests. The linger time of writers suffices for a slow network; the
// library's default would add up over all writers, which end one after the other. A receive thread per socket is woken
// at its end by a packet to the participant's own address and hangs if that has changed; the single thread for all
// sockets uses a pipe.
constexpr std::string_view kBufferAndThreadSettings =
    "<Sizing><ReceiveBufferSize>256 KiB</ReceiveBufferSize><ReceiveBufferChunkSize>64 KiB</ReceiveBufferChunkSize>"
    "</Sizing><Internal><MultipleReceiveThreads>false</MultipleReceiveThreads>"
    "<WriterLingerDuration>200 ms</WriterLingerDuration>"
    "<SocketReceiveBufferSize min=\"default\" max=\"512 KiB\"/></Internal>";

std::string library(const std::string& folder, std::string_view plugin, std::string_view what) {
  const std::string path = folder + "/lib" + std::string(plugin) + ".so";
  return "<Library path=\"" + escaped(path) + "\" initFunction=\"init_" + std::string(what) +
         "\" finalizeFunction=\"finalize_" + std::string(what) + "\"/>";
}

std::string security(const SecurityConfig& config) {
  const std::string folder = security_plugin_folder(config);
  const auto file = [](std::string_view name, const std::string& path) {
    return element(name, "file:" + std::filesystem::absolute(path).string());
  };
  return "<Security><Authentication>" + library(folder, "dds_security_auth", "authentication") +
         file("IdentityCA", config.identity_ca) + file("IdentityCertificate", config.certificate) +
         file("PrivateKey", config.private_key) + "</Authentication><AccessControl>" +
         library(folder, "dds_security_ac", "access_control") +
         file("PermissionsCA", config.permissions_ca.empty() ? config.identity_ca : config.permissions_ca) +
         file("Governance", config.governance) + file("Permissions", config.permissions) +
         "</AccessControl><Cryptographic>" + library(folder, "dds_security_crypto", "crypto") +
         "</Cryptographic></Security>";
}

// XML without comments, in lower case: the library ignores the case of names.
std::string plain_xml(std::string_view xml) {
  std::string plain;
  for (std::size_t i = 0; i < xml.size();) {
    const std::size_t comment = std::min(xml.find("<!--", i), xml.size());
    std::transform(xml.begin() + static_cast<std::ptrdiff_t>(i), xml.begin() + static_cast<std::ptrdiff_t>(comment),
                   std::back_inserter(plain), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const std::size_t end = xml.find("-->", comment);
    i = end == std::string_view::npos ? xml.size() : end + 3;
  }
  return plain;
}

// The Id attribute of each Domain element; an element without it applies to any domain.
Status check_domains(const PublishConfig& config, const std::string& plain) {
  for (std::size_t tag = plain.find("<domain"); tag != std::string::npos; tag = plain.find("<domain", tag + 1)) {
    const std::string attributes = plain.substr(tag, plain.find('>', tag) - tag);
    const std::size_t id = attributes.find(" id=");
    if (id == std::string::npos) {
      continue;
    }
    const std::size_t value = id + 5;  // After the quote.
    const std::string named = attributes.substr(value, attributes.find_first_of("\"'", value) - value);
    if (named != "any" && named != "*" && named != std::to_string(config.domain)) {
      return fail(ErrorCode::kInvalidConfig, config.xml + " configures domain " + named + ", but dds.domain is " +
                                                 std::to_string(config.domain) +
                                                 "; it would be ignored; make the two agree, or write Id=\"any\"");
    }
  }
  return {};
}

}  // namespace

std::string domain_xml(const PublishConfig& config, bool interface_has_multicast) {
  return "<CycloneDDS><Domain Id=\"any\">" + general(config, interface_has_multicast) + discovery(config) +
         std::string(kBufferAndThreadSettings) +
         (config.security.mode == SecurityMode::kRequired ? security(config.security) : "") + "</Domain></CycloneDDS>";
}

Result<std::string> read_own_xml(const PublishConfig& config) {
  if (std::error_code error; !std::filesystem::exists(config.xml, error)) {
    const Error reason = unreachable(config.xml, "does not exist; correct the path").error();
    return fail(reason.code, "dds.xml: " + reason.message);
  }
  std::ifstream file(config.xml, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file || content.str().empty()) {
    return fail(ErrorCode::kIo, "dds.xml: " + config.xml + " cannot be read, or is empty");
  }
  const std::string plain = plain_xml(content.str());
  if (plain.find("<cyclonedds") == std::string::npos) {
    return fail(ErrorCode::kInvalidConfig, "dds.xml: " + config.xml + " has no element CycloneDDS");
  }
  for (const std::string_view part : {"<sharedmemory", "<security", "<ddssecurity"}) {
    if (plain.find(part) != std::string::npos) {
      return fail(ErrorCode::kInvalidConfig,
                  "dds.xml: " + config.xml + " has an element " + std::string(part.substr(1)) +
                      (part == "<sharedmemory" ? ", which ends the process where its daemon is missing; remove it"
                                               : "; remove it and use the keys dds.security.*"));
    }
  }
  if (const Status domains = check_domains(config, plain); !domains) {
    return Unexpected(domains.error());
  }
  return content.str();
}

}  // namespace kinetrace::publishing
