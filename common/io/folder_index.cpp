#include "common/io/folder_index.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace lode {
namespace {

namespace fs = std::filesystem;

/// Returns true if an entry of a folder is a regular file, or a link to a regular file inside `root`.
bool isFileBelow(const fs::directory_entry& entry, const fs::path& root) {
  std::error_code failed;
  if (!entry.is_symlink(failed)) return entry.is_regular_file(failed);
  const fs::path target = fs::canonical(entry.path(), failed);
  return !failed && isInside(target, root) && fs::is_regular_file(target, failed);
}

}  // namespace

bool isInside(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

std::string lowerCase(std::string_view name) {
  std::string lower(name);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

FolderIndex::FolderIndex(const fs::path& folder) : root_(folder) {
  Files level{folder};
  for (size_t depth = 0; depth <= kMaxDepth && !level.empty() && !is_cut_; ++depth) {
    Files next;
    for (size_t i = 0; i < level.size() && !is_cut_; ++i) {
      Files below = addFolder(level[i]);
      std::move(below.begin(), below.end(), std::back_inserter(next));
    }
    level = std::move(next);
  }
}

FolderIndex::Files FolderIndex::addFolder(const fs::path& folder) {
  Files files, folders;
  std::error_code failed;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    is_cut_ = ++entries_ > kMaxEntries;
    if (is_cut_) return {};
    const fs::directory_entry& entry = *at;
    if (isHidden(entry.path().filename().string())) continue;
    std::error_code unknown;
    if (entry.is_directory(unknown) && !entry.is_symlink(unknown))
      folders.push_back(entry.path());
    else if (isFileBelow(entry, root_))
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& file : files) {
    by_name_[lowerCase(file.filename().string())].push_back(file);
    by_stem_[lowerCase(file.stem().string())].push_back(file);
  }
  return folders;
}

const FolderIndex::Files& FolderIndex::find(const Names& names, const std::string& name) {
  static const Files kNone;
  const auto found = names.find(name);
  return found == names.end() ? kNone : found->second;
}

}  // namespace lode
