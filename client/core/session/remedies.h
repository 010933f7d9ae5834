#pragma once

namespace lode::core {

/// What to do where an option would help, in the words of the program around the core: ends of messages. As
/// they are, they name no option.
struct Remedies {
  const char* model = "name one that it has";
  const char* token = "give a token that it knows";
  const char* certificate = "name the host as the certificate does, and trust its authority";
  const char* authorities = "give certificates in PEM";
  const char* cache_folder = "choose another folder";
};

}  // namespace lode::core
