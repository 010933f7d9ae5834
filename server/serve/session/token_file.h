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

/// What the bearer of a token may do.
struct TokenGrant {
  bool all_models = false;
  std::vector<std::string> models;  ///< sorted: those that it may list and open, where not all
  std::optional<std::chrono::sys_seconds>
      expires;  ///< the year 9999 is beyond what the clock's own type holds

  bool allows(std::string_view model) const noexcept;
  bool hasExpired(std::chrono::system_clock::time_point now) const noexcept {
    return expires && std::chrono::floor<std::chrono::seconds>(now) >= *expires;
  }
};

/// The tokens of a server, immutable. A line of the file is
///
///     TOKEN  EXPIRY  MODEL [MODEL ...]
///
/// with EXPIRY "never" or a time like 2027-01-31T12:00:00Z, and "*" as the only model for all of them; names
/// with spaces stand in double quotes. Empty lines and those that begin with # are skipped. Tokens are kept
/// as hashes alone. Thread safe.
class TokenFile {
 public:
  /// @throws Error kUsage, naming the line and never the token; kLimit.
  static TokenFile parse(std::string_view text);
  /// @throws Error kIo too.
  static TokenFile read(const std::filesystem::path& path);

  /// Compares with every token, in a time that does not tell how near one came.
  /// @return nothing where no token is the same, or it has expired; valid as long as this.
  const TokenGrant* find(std::string_view token, std::chrono::system_clock::time_point now) const;

  /// In all of its lines, sorted, each once.
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
