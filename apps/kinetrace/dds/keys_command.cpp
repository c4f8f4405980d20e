#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/messages.hpp"
#include "dds/authority.hpp"
#include "dds/dds_command_line.hpp"
#include "dds/dds_permissions.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kDay_s = 86'400;
constexpr std::int64_t kAuthorityDays = 3650;
constexpr std::int64_t kYear2020_s = 1'577'836'800;
constexpr mode_t kSecret = 0600;
constexpr mode_t kPublic = 0644;

// Paths are relative to this file, so that the folder can be copied anywhere.
constexpr const char* kSettingsName = "dds.yaml";
constexpr std::string_view kSettings =
    "# Security of DDS with the files beside this one; all other keys of dds.* may be added.\n"
    "dds:\n"
    "  security:\n"
    "    mode: required\n"
    "    identity_ca: identity_ca.cert.pem\n"
    "    certificate: cert.pem\n"
    "    private_key: key.pem\n"
    "    permissions_ca: permissions_ca.cert.pem\n"
    "    governance: governance.p7s\n"
    "    permissions: permissions.p7s\n";

struct File {
  std::string name;
  std::string content;
  mode_t mode;
};

struct Participant {
  std::string name;
  DdsRole role;
};

/// Never overwrites.
Outcome<void> write_file(const fs::path& path, const File& file) {
  const int out = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, file.mode);
  if (out < 0) {
    return Unexpected(Failure{ExitCode::kCannotCreate, path.string() + " cannot be made: " + std::strerror(errno)});
  }
  const ssize_t written = write(out, file.content.data(), file.content.size());
  const bool is_kept = fsync(out) == 0;
  close(out);
  if (written != static_cast<ssize_t>(file.content.size()) || !is_kept) {
    return Unexpected(Failure{ExitCode::kIo, path.string() + " cannot be written; is the disk full?"});
  }
  return {};
}

/// Writes all files; removes the folder after a failure.
Outcome<void> write_folder(const fs::path& folder, const std::vector<File>& files, fs::perms permissions) {
  std::error_code error;
  fs::create_directories(folder.parent_path(), error);
  if (error || !fs::create_directory(folder, error)) {
    return Unexpected(Failure{ExitCode::kCannotCreate,
                              folder.string() + " cannot be made: " + (error ? error.message() : "it exists already")});
  }
  fs::permissions(folder, permissions, error);
  for (const File& file : files) {
    if (Outcome<void> written = write_file(folder / file.name, file); !written) {
      fs::remove_all(folder, error);
      return written;
    }
  }
  return {};
}

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// The keystore in the layout of ROS 2, so that its tools find an enclave by its name.
class Keystore {
 public:
  explicit Keystore(fs::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] fs::path authority_key() const { return folder_ / "private" / "ca.key.pem"; }
  [[nodiscard]] fs::path authority_certificate() const { return folder_ / "public" / "ca.cert.pem"; }
  [[nodiscard]] fs::path enclave(const std::string& name) const { return folder_ / "enclaves" / name; }

  /// The existing authority, else a new one.
  [[nodiscard]] Outcome<Authority> authority(std::int64_t now_s) const {
    std::error_code absent;
    if (!fs::exists(authority_key(), absent)) {
      return new_authority(now_s);
    }
    Result<Authority> known = Authority::read({text_of(authority_certificate()), text_of(authority_key())});
    if (!known) {
      return Unexpected(Failure{ExitCode::kBadData, folder_.string() + ": " + known.error().message});
    }
    return std::move(*known);
  }

 private:
  [[nodiscard]] Outcome<Authority> new_authority(std::int64_t now_s) const {
    std::error_code absent;
    if (fs::exists(folder_, absent) && !fs::is_empty(folder_, absent)) {
      return Unexpected(Failure{ExitCode::kCannotCreate, folder_.string() +
                                                             " is not empty and holds no private/ca.key.pem; "
                                                             "name a new folder"});
    }
    Result<Authority> made =
        Authority::make("Kinetrace DDS authority", {now_s - kDay_s, now_s + kAuthorityDays * kDay_s});
    const Result<Identity> pem = made ? made->pem() : Unexpected(made.error());
    if (!pem) {
      return failure(pem.error());
    }
    if (const Outcome<void> key = write_folder(authority_key().parent_path(),
                                               {{"ca.key.pem", pem->private_key, kSecret}}, fs::perms::owner_all);
        !key) {
      return Unexpected(key.error());
    }
    constexpr fs::perms kForAll = fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                                  fs::perms::others_read | fs::perms::others_exec;
    if (const Outcome<void> certificate =
            write_folder(authority_certificate().parent_path(), {{"ca.cert.pem", pem->certificate, kPublic}}, kForAll);
        !certificate) {
      return Unexpected(certificate.error());
    }
    return std::move(*made);
  }

  fs::path folder_;
};

/// All files that a participant needs, without secrets of others.
Result<std::vector<File>> enclave_files(const Authority& authority, const Participant& participant,
                                        std::string_view ros_prefix, const Validity& validity) {
  const Result<Identity> own = authority.pem();
  const Result<Identity> identity = authority.issue(participant.name, validity);
  const Result<std::string> governance = authority.sign(governance_xml());
  const Result<std::string> permissions =
      authority.sign(permissions_xml(participant.name, participant.role, ros_prefix, validity));
  for (const Error* error :
       {own ? nullptr : &own.error(), identity ? nullptr : &identity.error(),
        governance ? nullptr : &governance.error(), permissions ? nullptr : &permissions.error()}) {
    if (error != nullptr) {
      return Unexpected(*error);
    }
  }
  return std::vector<File>{{"identity_ca.cert.pem", own->certificate, kPublic},
                           {"permissions_ca.cert.pem", own->certificate, kPublic},
                           {"cert.pem", identity->certificate, kPublic},
                           {"key.pem", identity->private_key, kSecret},
                           {"governance.p7s", *governance, kPublic},
                           {"permissions.p7s", *permissions, kPublic},
                           {kSettingsName, std::string(kSettings), kPublic}};
}

std::vector<Participant> participants(const KeysOptions& options) {
  std::vector<Participant> all;
  const auto add = [&all](const std::vector<std::string>& names, DdsRole role) {
    for (const std::string& name : names) {
      all.push_back({name, role});
    }
  };
  add(options.devices, DdsRole::kDevice);
  add(options.viewers, DdsRole::kViewer);
  add(options.segmenters, DdsRole::kSegmenter);
  if (all.empty()) {
    all = {{"kinetrace", DdsRole::kDevice}, {"viewer", DdsRole::kViewer}};
  }
  return all;
}

Outcome<void> check_new(const Keystore& keystore, const std::vector<Participant>& all) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (all[i].name == all[j].name) {
        return Unexpected(
            Failure{ExitCode::kUsage, "the name " + all[i].name + " is given twice; everybody needs one of their own"});
      }
    }
    std::error_code absent;
    if (fs::exists(keystore.enclave(all[i].name), absent)) {
      return Unexpected(
          Failure{ExitCode::kCannotCreate, keystore.enclave(all[i].name).string() +
                                               " exists already and is not overwritten; remove it to make it anew, or "
                                               "choose another name"});
    }
  }
  return {};
}

Outcome<Validity> validity_of(const KeysOptions& options, const Authority& authority, std::int64_t now_s) {
  // Valid from yesterday on: clocks differ, and some machines do not keep UTC.
  const Validity wanted{now_s - kDay_s, now_s + options.days * kDay_s};
  if (wanted.end_s > authority.end_s()) {
    return Unexpected(Failure{ExitCode::kUsage, "the authority ends " + utc_text(authority.end_s()) +
                                                    ", before --days " + std::to_string(options.days) +
                                                    "; ask for fewer days, or make a new authority in a new folder"});
  }
  return wanted;
}

Outcome<void> make_keys(const KeysOptions& options, std::int64_t now_s) {
  if (now_s < kYear2020_s) {
    return Unexpected(Failure{ExitCode::kConfig, "the system clock says " + utc_text(now_s) +
                                                     "; set it first, since certificates are valid by it"});
  }
  const Keystore keystore(options.out);
  const std::vector<Participant> all = participants(options);
  if (Outcome<void> is_new = check_new(keystore, all); !is_new) {
    return is_new;
  }
  const Outcome<Authority> authority = keystore.authority(now_s);
  if (!authority) {
    return Unexpected(authority.error());
  }
  const Outcome<Validity> validity = validity_of(options, *authority, now_s);
  if (!validity) {
    return Unexpected(validity.error());
  }
  std::printf("authority  valid until %s  %s (keep this key off every device; it makes further identities)\n",
              utc_text(authority->end_s()).c_str(), keystore.authority_key().c_str());
  for (const Participant& participant : all) {
    const Result<std::vector<File>> files = enclave_files(*authority, participant, options.ros_prefix, *validity);
    if (!files) {
      return failure(files.error());
    }
    const fs::path enclave = keystore.enclave(participant.name);
    if (Outcome<void> written = write_folder(enclave, *files, fs::perms::owner_all); !written) {
      return written;
    }
    std::printf("%-9s  valid until %s  %s\n", std::string(to_string(participant.role)).c_str(),
                utc_text(validity->end_s).c_str(), enclave.c_str());
  }
  std::printf("\nCopy each folder to its machine, and nothing else. On a device: kinetrace run --publish %s\n",
              (keystore.enclave(all.front().name) / kSettingsName).c_str());
  return {};
}

}  // namespace

int keys_command(const KeysOptions& options) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const Outcome<void> made = make_keys(options, std::chrono::duration_cast<std::chrono::seconds>(now).count());
  return made ? 0 : report(made.error());
}

}  // namespace kinetrace::app
