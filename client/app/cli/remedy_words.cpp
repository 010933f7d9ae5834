#include "client/app/cli/remedy_words.h"

namespace lode::app {

const char* wordsFor(Remedy remedy) noexcept {
  switch (remedy) {
    case Remedy::kNone:
      return "";
    case Remedy::kModel:
      return "lodestream list shows what it has";
    case Remedy::kToken:
      return "give a token with --token-file or LODESTREAM_TOKEN";
    case Remedy::kCertificate:
      return "use the host name of the certificate, and give its authority with --ca-file";
    case Remedy::kAuthorities:
      return "give certificates in PEM with --ca-file";
    case Remedy::kCacheFolder:
      return "give --cache a folder, or off";
    case Remedy::kForeignCacheFolder:
      return "remove it, or give --cache a folder, or off";
  }
  return "";
}

std::string withRemedy(const std::string& message, Remedy remedy) {
  return remedy == Remedy::kNone ? message : message + "; " + wordsFor(remedy);
}

std::string messageOf(const Error& error) { return withRemedy(error.what(), error.remedy()); }

}  // namespace lode::app
