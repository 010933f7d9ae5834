#include "server/ingest/disk/temporary_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"

namespace lode::ingest {
namespace {

[[noreturn]] void fail(const std::filesystem::path& parent, const FolderUse& use) {
  throw Error(ErrorCode::kIo, std::string("cannot make a folder for ") + use.what + " in " + parent.string() +
                                  ": " + std::strerror(errno) + "; " + use.remedy);
}

constexpr FolderUse kTemporaryFiles{"temporary files",
                                    "set another folder with --tmp (lodestream: XDG_CACHE_HOME)"};

}  // namespace

void makeOwnFolder(const std::filesystem::path& path, const FolderUse& use) {
  if (::mkdir(path.c_str(), 0700) == 0) return;
  if (errno != EEXIST) fail(path.parent_path(), use);
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return makeOwnFolder(path, use);  // another build ended and removed the folder
    fail(path.parent_path(), use);
  }
  if (!S_ISDIR(status.st_mode) || status.st_uid != ::geteuid() ||
      (status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    throw Error(ErrorCode::kIo,
                path.string() + ": is not a folder that only you can write to; remove it, or " + use.remedy);
  }
}

TemporaryFolder::TemporaryFolder(const std::filesystem::path& parent) {
  std::string name = (parent / ".lodestream-build-XXXXXX").string();
  const Uninterrupted until_it_is_known;
  if (::mkdtemp(name.data()) == nullptr) fail(parent, kTemporaryFiles);
  path_ = name;
  unfinished_ = Unfinished(path_);
}

TemporaryFolder TemporaryFolder::lasting(std::filesystem::path path) {
  TemporaryFolder folder;
  folder.path_ = std::move(path);
  folder.is_lasting_ = true;
  makeOwnFolder(folder.path_, kTemporaryFiles);
  return folder;
}

TemporaryFolder::~TemporaryFolder() {
  if (is_lasting_ || path_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      unfinished_(std::move(other.unfinished_)),
      is_lasting_(other.is_lasting_) {}

}  // namespace lode::ingest
