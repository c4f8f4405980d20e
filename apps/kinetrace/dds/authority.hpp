// A certificate authority for DDS Security: certifies the participants of a domain and signs their permissions.
#pragma once

#include <cstdint>
#include <memory>
#include <openssl/evp.h>
#include <openssl/x509.h>
#include <string>
#include <string_view>

#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

/// Seconds of the system clock (Unix), both included.
struct Validity {
  std::int64_t begin_s = 0;
  std::int64_t end_s = 0;
};

/// A certificate and its private key; PEM, the key without a password.
struct Identity {
  std::string certificate;
  std::string private_key;
};

/// Certificate and key of a trusted authority. Keys are ECDSA P-256, as DDS Security 1.1 asks for.
class Authority {
 public:
  /// Creates a new authority. Errors: kInternal (failure of the cryptographic library).
  [[nodiscard]] static Result<Authority> make(std::string_view name, const Validity& validity);
  /// From PEM text. Errors: kBadFormat.
  [[nodiscard]] static Result<Authority> read(const Identity& pem);

  [[nodiscard]] Result<Identity> pem() const;
  [[nodiscard]] std::int64_t end_s() const noexcept;

  /// Certifies a new key; the subject is "CN=name". Errors: kInternal.
  [[nodiscard]] Result<Identity> issue(std::string_view name, const Validity& validity) const;
  /// The document with its signature, S/MIME. Errors: kInternal.
  [[nodiscard]] Result<std::string> sign(std::string_view document) const;

 private:
  template <auto Free>
  struct Freed {
    template <typename T>
    void operator()(T* object) const noexcept {
      Free(object);
    }
  };
  using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
  using Certificate = std::unique_ptr<X509, Freed<X509_free>>;

  Authority(Key key, Certificate certificate) : key_(std::move(key)), certificate_(std::move(certificate)) {}

  Key key_;
  Certificate certificate_;
};

}  // namespace kinetrace::app
