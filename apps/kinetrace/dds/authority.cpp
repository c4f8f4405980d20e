#include "dds/authority.hpp"

#include <array>
#include <cstddef>
#include <ctime>
#include <initializer_list>
#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <utility>

namespace kinetrace::app {
namespace {

struct FreeBio {
  void operator()(BIO* bio) const noexcept { BIO_free_all(bio); }
};
using Bio = std::unique_ptr<BIO, FreeBio>;

Unexpected<Error> refused(std::string_view what) {
  const unsigned long code = ERR_get_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return fail(ErrorCode::kInternal,
              "OpenSSL cannot " + std::string(what) + ": " + (reason == nullptr ? "no reason given" : reason));
}

Bio reader(std::string_view text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

std::string content(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(size)};
}

// 127 random bits: serial numbers of one authority must be unique.
bool set_serial(X509* certificate) {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return false;
  }
  bytes[0] &= 0x7F;
  BIGNUM* number = BN_bin2bn(bytes.data(), static_cast<int>(bytes.size()), nullptr);
  const bool is_set = number != nullptr && BN_to_ASN1_INTEGER(number, X509_get_serialNumber(certificate)) != nullptr;
  BN_free(number);
  return is_set;
}

bool set_subject(X509* certificate, std::string_view name) {
  return X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>(name.data()), static_cast<int>(name.size()),
                                    -1, 0) == 1;
}

bool set_validity(X509* certificate, const Validity& validity) {
  return ASN1_TIME_set(X509_getm_notBefore(certificate), static_cast<std::time_t>(validity.begin_s)) != nullptr &&
         ASN1_TIME_set(X509_getm_notAfter(certificate), static_cast<std::time_t>(validity.end_s)) != nullptr;
}

struct Extension {
  int kind;
  const char* value;
};

bool add_extensions(X509* certificate, X509* issuer, std::initializer_list<Extension> extensions) {
  for (const Extension& wanted : extensions) {
    X509V3_CTX context;
    X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
    X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, wanted.kind, wanted.value);
    const bool is_added = extension != nullptr && X509_add_ext(certificate, extension, -1) == 1;
    X509_EXTENSION_free(extension);
    if (!is_added) {
      return false;
    }
  }
  return true;
}

// The signature comes last, over everything else.
bool fill(X509* certificate, std::string_view name, const Validity& validity, EVP_PKEY* key, X509* issuer,
          std::initializer_list<Extension> extensions) {
  return certificate != nullptr && key != nullptr && X509_set_version(certificate, X509_VERSION_3) == 1 &&
         set_serial(certificate) && set_subject(certificate, name) && set_validity(certificate, validity) &&
         X509_set_pubkey(certificate, key) == 1 && add_extensions(certificate, issuer, extensions);
}

Result<Identity> to_pem(X509* certificate, EVP_PKEY* key) {
  const Bio certificate_text(BIO_new(BIO_s_mem()));
  const Bio key_text(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_X509(certificate_text.get(), certificate) != 1 ||
      PEM_write_bio_PrivateKey(key_text.get(), key, nullptr, nullptr, 0, nullptr, nullptr) != 1) {
    return refused("write a key and its certificate");
  }
  return Identity{content(certificate_text.get()), content(key_text.get())};
}

}  // namespace

Result<Authority> Authority::make(std::string_view name, const Validity& validity) {
  Key key(EVP_EC_gen("P-256"));
  Certificate certificate(X509_new());
  // digitalSignature: it signs documents too, not only certificates.
  const bool is_filled = fill(certificate.get(), name, validity, key.get(), certificate.get(),
                              {{NID_basic_constraints, "critical,CA:TRUE"},
                               {NID_key_usage, "critical,digitalSignature,keyCertSign,cRLSign"},
                               {NID_subject_key_identifier, "hash"}});
  if (!is_filled || X509_set_issuer_name(certificate.get(), X509_get_subject_name(certificate.get())) != 1 ||
      X509_sign(certificate.get(), key.get(), EVP_sha256()) == 0) {
    return refused("make an authority");
  }
  return Authority(std::move(key), std::move(certificate));
}

Result<Authority> Authority::read(const Identity& pem) {
  ERR_clear_error();
  Key key(PEM_read_bio_PrivateKey(reader(pem.private_key).get(), nullptr, nullptr, nullptr));
  Certificate certificate(PEM_read_bio_X509(reader(pem.certificate).get(), nullptr, nullptr, nullptr));
  if (!key || !certificate || X509_check_private_key(certificate.get(), key.get()) != 1) {
    return fail(ErrorCode::kBadFormat,
                "the key and the certificate of the authority are damaged or do not belong together");
  }
  return Authority(std::move(key), std::move(certificate));
}

Result<Identity> Authority::pem() const {
  return to_pem(certificate_.get(), key_.get());
}

std::int64_t Authority::end_s() const noexcept {
  std::tm end{};
  return ASN1_TIME_to_tm(X509_get0_notAfter(certificate_.get()), &end) == 1 ? timegm(&end) : 0;
}

Result<Identity> Authority::issue(std::string_view name, const Validity& validity) const {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate(X509_new());
  const bool is_filled = fill(certificate.get(), name, validity, key.get(), certificate_.get(),
                              {{NID_basic_constraints, "critical,CA:FALSE"},
                               {NID_key_usage, "critical,digitalSignature,keyAgreement"},
                               {NID_subject_key_identifier, "hash"},
                               {NID_authority_key_identifier, "keyid:always"}});
  if (!is_filled || X509_set_issuer_name(certificate.get(), X509_get_subject_name(certificate_.get())) != 1 ||
      X509_sign(certificate.get(), key_.get(), EVP_sha256()) == 0) {
    return refused("certify " + std::string(name));
  }
  return to_pem(certificate.get(), key.get());
}

Result<std::string> Authority::sign(std::string_view document) const {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;  // Clear text followed by the signature.
  const Bio in = reader(document);
  const std::unique_ptr<PKCS7, Freed<PKCS7_free>> signature(
      PKCS7_sign(certificate_.get(), key_.get(), nullptr, in.get(), kFlags));
  const Bio out(BIO_new(BIO_s_mem()));
  if (!signature || BIO_reset(in.get()) != 1 || SMIME_write_PKCS7(out.get(), signature.get(), in.get(), kFlags) != 1) {
    return refused("sign a document");
  }
  return content(out.get());
}

}  // namespace kinetrace::app
