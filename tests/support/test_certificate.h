#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

namespace lode::test {

/// Writes a self-signed certificate, which is valid from now on for a given time, and its key, which only
/// this user can read.
inline void writeCertificate(const std::filesystem::path& certificate, const std::filesystem::path& key,
                             long seconds = 3600) {
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> pair(EVP_EC_gen("P-256"), EVP_PKEY_free);
  const std::unique_ptr<X509, decltype(&X509_free)> x509(X509_new(), X509_free);
  ASN1_INTEGER_set(X509_get_serialNumber(x509.get()), 1);
  X509_gmtime_adj(X509_getm_notBefore(x509.get()), 0);
  X509_gmtime_adj(X509_getm_notAfter(x509.get()), seconds);
  X509_set_pubkey(x509.get(), pair.get());
  X509_NAME* const name = X509_get_subject_name(x509.get());
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("localhost"),
                             -1, -1, 0);
  X509_set_issuer_name(x509.get(), name);
  X509_sign(x509.get(), pair.get(), EVP_sha256());
  using File = std::unique_ptr<FILE, int (*)(FILE*)>;
  PEM_write_X509(File(std::fopen(certificate.c_str(), "w"), std::fclose).get(), x509.get());
  PEM_write_PrivateKey(File(std::fopen(key.c_str(), "w"), std::fclose).get(), pair.get(), nullptr, nullptr, 0,
                       nullptr, nullptr);
  std::filesystem::permissions(key, std::filesystem::perms(0600));
}

}  // namespace lode::test
