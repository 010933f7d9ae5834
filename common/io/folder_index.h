#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace lode {

/// Returns true if a canonical path is `folder` itself or lies below it.
bool isInside(const std::filesystem::path& path, const std::filesystem::path& folder);

/// Returns true if a name begins with a dot.
inline bool isHidden(std::string_view name) noexcept { return name.starts_with('.'); }

/// Returns a name with its ASCII letters converted to lower case.
std::string lowerCase(std::string_view name);

/// Index of the regular files in a folder and its subfolders by name, without regard to the case of ASCII
/// letters. Skips hidden files and folders, links to folders, and links to files outside the folder. Searches
/// at most kMaxEntries entries and kMaxDepth levels of subfolders, nearest folders first. If the entries of a
/// folder would exceed kMaxEntries, neither this folder nor any later folder is searched, so that the result
/// does not depend on the order in which the system lists a folder. Thread safe.
class FolderIndex {
 public:
  static constexpr size_t kMaxEntries = 20'000, kMaxDepth = 4;
  using Files = std::vector<std::filesystem::path>;

  /// @param folder  canonical path. A folder that cannot be read counts as empty.
  explicit FolderIndex(const std::filesystem::path& folder);

  /// Returns the files with this name, nearest folders first.
  const Files& named(std::string_view name) const { return find(by_name_, lowerCase(name)); }
  /// Returns the files with this name before the extension, nearest folders first.
  const Files& withStem(std::string_view stem) const { return find(by_stem_, lowerCase(stem)); }
  /// Returns true if the search stopped at kMaxEntries.
  bool isCut() const noexcept { return is_cut_; }

 private:
  using Names = std::map<std::string, Files, std::less<>>;

  static const Files& find(const Names& names, const std::string& name);
  /// Adds the files of one folder. @return its subfolders.
  Files addFolder(const std::filesystem::path& folder);

  const std::filesystem::path root_;
  size_t entries_ = 0;
  bool is_cut_ = false;
  Names by_name_, by_stem_;
};

}  // namespace lode
