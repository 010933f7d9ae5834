#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace lode::app {

constexpr size_t kMostRecentTargets = 20;

/// The targets that the user has opened last, in a file that only the user can read.
class RecentTargets {
 public:
  /// @param folder  folder of the program; created when a target is added.
  explicit RecentTargets(const std::filesystem::path& folder) : file_(folder / "recent.json") {}

  /// Returns the targets, newest first: absolute paths of files, and models on servers. Ignores a file that
  /// is missing, too long or has other contents.
  std::vector<std::string> read() const;
  /// Puts a target first. If the folder cannot be written, the list stays as it is.
  void add(std::string_view target) const;

 private:
  std::filesystem::path file_;
};

/// Returns true if a target is a file that does not exist.
bool isMissing(std::string_view target);

}  // namespace lode::app
