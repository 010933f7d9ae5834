#pragma once

namespace lode::core {

/// Advice that ends an error message if an option of the program can solve the problem. Programs replace the
/// default texts by texts that name their own options.
struct Remedies {
  const char* model = "name a model of this server";
  const char* token = "give a valid token";
  const char* certificate = "use the host name of the certificate, and trust its authority";
  const char* authorities = "give certificates in PEM";
  const char* cache_folder = "choose another folder";
};

}  // namespace lode::core
