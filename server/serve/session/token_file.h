#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/codec/blob.h"

namespace lode::serve {

constexpr size_t kMaxTokenFileBytes = 1u << 20;
constexpr size_t kMaxTokens = 4096;

/// Rights of a token.
struct TokenGrant {
  bool all_models = false;
  /// Sorted names of the models that a client with the token can list and open; unused with all_models.
  std::vector<std::string> models;
  /// Time at which the token expires, in seconds, because nanoseconds would overflow long before the year
  /// 9999.
  std::optional<std::chrono::sys_seconds> expires;

  bool allows(std::string_view model) const noexcept;
  bool hasExpired(std::chrono::system_clock::time_point now) const noexcept {
    return expires && std::chrono::floor<std::chrono::seconds>(now) >= *expires;
  }
};

/// The tokens of a server. Immutable. Each line of the file has the form
///
///     TOKEN  EXPIRY  MODEL [MODEL ...]
///
/// EXPIRY is "never" or a time like 2027-01-31T12:00:00Z. A single "*" allows all models. Names with spaces
/// are in double quotes. "#" begins a comment; empty lines are ignored. Only hashes of the tokens stay in
/// memory. Thread safe.
class TokenFile {
 public:
  /// Parses the text of a token file. @throws Error kLimit; Error kUsage, whose message names the line but
  /// never the token.
  static TokenFile parse(std::string_view text);
  /// Reads a token file. @throws Error as parse() does, and kIo.
  static TokenFile read(const std::filesystem::path& path);

  /// Finds the rights of a token. Always compares all tokens, so that the duration of the search reveals
  /// nothing about them.
  /// @return the rights, valid as long as this object, or null if the token is unknown or has expired.
  const TokenGrant* find(std::string_view token, std::chrono::system_clock::time_point now) const;

  /// Returns the model names of all lines, sorted and without duplicates.
  std::vector<std::string> modelsNamed() const;

  bool allHaveExpired(std::chrono::system_clock::time_point now) const noexcept;

  size_t size() const noexcept { return entries_.size(); }

 private:
  struct Entry {
    Digest hash;  ///< SHA-256, cut to 128 bits
    TokenGrant grant;
  };
  std::vector<Entry> entries_;
};

}  // namespace lode::serve
