#include "server/ingest/disk/temporary_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "common/error.h"
#include "common/io/own_folder.h"

namespace lode::ingest {
namespace {

constexpr FolderUse kTemporaryFiles{"temporary files",
                                    "set another folder with --tmp (lodestream: XDG_CACHE_HOME)"};

}  // namespace

TemporaryFolder::TemporaryFolder(const std::filesystem::path& parent) {
  std::string name = (parent / ".lodestream-build-XXXXXX").string();
  const Uninterrupted until_it_is_known;
  if (::mkdtemp(name.data()) == nullptr)
    throw Error(ErrorCode::kIo, std::string("cannot make a folder for ") + kTemporaryFiles.what + " in " +
                                    parent.string() + ": " + std::strerror(errno) + "; " +
                                    kTemporaryFiles.remedy);
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
