#include "server/ingest/temporary_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include <sys/stat.h>

#include "common/error.h"

namespace lode::ingest {
namespace {

[[noreturn]] void fail(const std::filesystem::path& parent) {
  throw Error(ErrorCode::kIo, "cannot make a folder for temporary files in " + parent.string() + ": " +
                                  std::strerror(errno) + "; name another with --tmp");
}

}  // namespace

TemporaryFolder::TemporaryFolder(const std::filesystem::path& parent) {
  std::string name = (parent / ".lodestream-build-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) fail(parent);
  path_ = name;
}

TemporaryFolder TemporaryFolder::lasting(std::filesystem::path path) {
  TemporaryFolder folder;
  folder.path_ = std::move(path);
  folder.is_lasting_ = true;
  if (::mkdir(folder.path_.c_str(), 0700) != 0 && errno != EEXIST) fail(folder.path_.parent_path());
  return folder;
}

TemporaryFolder::~TemporaryFolder() {
  if (is_lasting_ || path_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})), is_lasting_(other.is_lasting_) {}

}  // namespace lode::ingest
