#pragma once

namespace lode::core {

/// Advice at the end of error messages that an option of the program would solve. Programs replace the
/// defaults by words that name their options.
struct Remedies {
  const char* model = "name one that it has";
  const char* token = "give a token that it knows";
  const char* certificate = "name the host as the certificate does, and trust its authority";
  const char* authorities = "give certificates in PEM";
  const char* cache_folder = "choose another folder";
};

}  // namespace lode::core
