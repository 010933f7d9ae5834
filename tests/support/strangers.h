#pragma once

#include <filesystem>

#include <sys/stat.h>
#include <unistd.h>

namespace lode::test {

constexpr uid_t kStranger = 65534;  ///< user that owns nothing on most systems

/// Gives a file, a folder or a link itself to another user. @return false if this process may not.
inline bool giveToStranger(const std::filesystem::path& path) {
  return ::geteuid() == 0 && ::lchown(path.c_str(), kStranger, static_cast<gid_t>(-1)) == 0;
}

/// Makes a folder in which everybody can place files, such as /tmp.
inline std::filesystem::path makeStickyFolder(const std::filesystem::path& path) {
  std::filesystem::create_directory(path);
  ::chmod(path.c_str(), S_ISVTX | S_IRWXU | S_IRWXG | S_IRWXO);
  return path;
}

inline mode_t modeOf(const std::filesystem::path& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 ? status.st_mode & ACCESSPERMS : 0;
}

}  // namespace lode::test
