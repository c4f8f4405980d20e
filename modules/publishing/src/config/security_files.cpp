#include "config/security_files.hpp"

#include <ctime>
#include <dlfcn.h>
#include <filesystem>
#include <memory>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <system_error>
#include <utility>

#include <dds/dds.h>

namespace kinetrace::publishing {
namespace {

template <auto Free>
struct Freed {
  template <typename T>
  void operator()(T* object) const noexcept {
    Free(object);
  }
};
using Bio = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using Signed = std::unique_ptr<PKCS7, Freed<PKCS7_free>>;
struct FreeStack {
  void operator()(STACK_OF(X509) * stack) const noexcept { sk_X509_free(stack); }
};

constexpr std::int64_t kYear2000_s = 946'684'800;

std::string named(std::string_view key, const std::string& path) {
  return "dds.security." + std::string(key) + ": " + path;
}

Result<Bio> open_file(std::string_view key, const std::string& path) {
  ERR_clear_error();
  std::error_code error;
  Bio file(std::filesystem::is_regular_file(path, error) ? BIO_new_file(path.c_str(), "rb") : nullptr);
  if (!file) {
    return fail(ErrorCode::kNotFound, named(key, path) + " does not exist or cannot be read");
  }
  return file;
}

// Without this callback an encrypted key would prompt for a password on the terminal.
int no_password(char* /*buffer*/, int /*size*/, int /*writes*/, void* /*user*/) {
  return -1;
}

Result<Key> read_key(const std::string& path) {
  Result<Bio> file = open_file("private_key", path);
  if (!file) {
    return Unexpected(file.error());
  }
  Key key(PEM_read_bio_PrivateKey(file->get(), nullptr, no_password, nullptr));
  if (!key) {
    return fail(
        ErrorCode::kInvalidConfig,
        named("private_key", path) + " is no private key in PEM format, or has a password; give it one without");
  }
  return key;
}

/// Errors also if it is not valid at `now_s`.
Result<Certificate> read_certificate(std::string_view key, const std::string& path, std::int64_t now_s) {
  Result<Bio> file = open_file(key, path);
  if (!file) {
    return Unexpected(file.error());
  }
  Certificate certificate(PEM_read_bio_X509(file->get(), nullptr, no_password, nullptr));
  if (!certificate) {
    return fail(ErrorCode::kInvalidConfig, named(key, path) + " is no certificate in PEM format");
  }
  auto now = static_cast<std::time_t>(now_s);
  if (X509_cmp_time(X509_get0_notBefore(certificate.get()), &now) > 0) {
    return fail(ErrorCode::kInvalidConfig,
                named(key, path) + " is not yet valid" +
                    (now_s < kYear2000_s ? "; the system clock has not been set yet (it says 1970): set it first"
                                         : "; set the system clock, or wait"));
  }
  if (X509_cmp_time(X509_get0_notAfter(certificate.get()), &now) < 0) {
    return fail(ErrorCode::kInvalidConfig, named(key, path) + " has expired; make a new one");
  }
  return certificate;
}

Status check_identity(const SecurityConfig& config, X509* authority, X509* certificate) {
  if (X509_verify(certificate, X509_get0_pubkey(authority)) != 1) {
    return fail(ErrorCode::kInvalidConfig, named("certificate", config.certificate) + " is not signed by " +
                                               config.identity_ca + " (dds.security.identity_ca)");
  }
  const Result<Key> key = read_key(config.private_key);
  if (!key) {
    return Unexpected(key.error());
  }
  if (X509_check_private_key(certificate, key->get()) != 1) {
    return fail(ErrorCode::kInvalidConfig, named("private_key", config.private_key) + " does not belong to " +
                                               config.certificate + " (dds.security.certificate)");
  }
  return {};
}

Status check_signer(const std::string& path, X509* authority) {
  const bool says_what_for = (X509_get_extension_flags(authority) & EXFLAG_KUSAGE) != 0;
  if (says_what_for && (X509_get_key_usage(authority) & KU_DIGITAL_SIGNATURE) == 0) {
    return fail(ErrorCode::kInvalidConfig, named("permissions_ca", path) +
                                               " may not sign documents: its keyUsage lacks digitalSignature; make one "
                                               "that has it");
  }
  return {};
}

Status check_signed(std::string_view key, const std::string& path, const std::string& authority_path, X509* authority) {
  Result<Bio> file = open_file(key, path);
  if (!file) {
    return Unexpected(file.error());
  }
  BIO* content = nullptr;
  const Signed document(SMIME_read_PKCS7(file->get(), &content));
  const Bio owned_content(content);
  if (!document || content == nullptr) {
    return fail(ErrorCode::kInvalidConfig,
                named(key, path) + " is no signed document; sign it with openssl smime -sign");
  }
  const std::unique_ptr<STACK_OF(X509), FreeStack> signers(sk_X509_new_null());
  sk_X509_push(signers.get(), authority);
  // The signer must be exactly this authority: no chain, and no certificate embedded in the document.
  constexpr int kFlags = PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN;
  if (PKCS7_verify(document.get(), signers.get(), nullptr, content, nullptr, kFlags) != 1) {
    return fail(ErrorCode::kInvalidConfig, named(key, path) + " is not signed by " + authority_path +
                                               ", or was changed afterwards; sign it again");
  }
  return {};
}

Status check_plugins(const SecurityConfig& config) {
  if (security_plugin_folder(config).empty()) {
    return fail(ErrorCode::kNotFound,
                "the security libraries of Cyclone DDS (libdds_security_auth.so and others) are not in " +
                    (config.plugins.empty() ? std::string("their place beside the DDS library") : config.plugins) +
                    "; name their folder with dds.security.plugins");
  }
  return {};
}

}  // namespace

std::string security_plugin_folder(const SecurityConfig& config) {
  namespace fs = std::filesystem;
  const auto has_plugins = [](const fs::path& folder) {
    std::error_code ignored;
    return fs::exists(folder / "libdds_security_auth.so", ignored);
  };
  if (!config.plugins.empty()) {
    return has_plugins(config.plugins) ? config.plugins : "";
  }
  Dl_info library{};
  if (dladdr(reinterpret_cast<const void*>(&dds_create_domain), &library) == 0) {
    return "";
  }
  const fs::path beside = fs::path(library.dli_fname).parent_path();
  for (const fs::path& folder : {beside, beside / "libddsc0debian"}) {
    if (has_plugins(folder)) {
      return folder.string();
    }
  }
  return "";
}

Status check_security_files(const SecurityConfig& config, std::int64_t now_s) {
  if (Status plugins = check_plugins(config); !plugins) {
    return plugins;
  }
  const Result<Certificate> identity_ca = read_certificate("identity_ca", config.identity_ca, now_s);
  if (!identity_ca) {
    return Unexpected(identity_ca.error());
  }
  const Result<Certificate> certificate = read_certificate("certificate", config.certificate, now_s);
  if (!certificate) {
    return Unexpected(certificate.error());
  }
  if (Status identity = check_identity(config, identity_ca->get(), certificate->get()); !identity) {
    return identity;
  }
  const std::string& signer_path = config.permissions_ca.empty() ? config.identity_ca : config.permissions_ca;
  const Result<Certificate> signer = read_certificate("permissions_ca", signer_path, now_s);
  if (!signer) {
    return Unexpected(signer.error());
  }
  if (Status may_sign = check_signer(signer_path, signer->get()); !may_sign) {
    return may_sign;
  }
  if (Status governance = check_signed("governance", config.governance, signer_path, signer->get()); !governance) {
    return governance;
  }
  return check_signed("permissions", config.permissions, signer_path, signer->get());
}

}  // namespace kinetrace::publishing
