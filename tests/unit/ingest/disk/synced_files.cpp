#include "tests/unit/ingest/disk/synced_files.h"

#include <filesystem>

#include <dlfcn.h>
#include <unistd.h>

namespace lode::test {
namespace {

thread_local SyncedFiles* files_of_thread = nullptr;

void noteSync(int file) {
  if (files_of_thread != nullptr) files_of_thread->note(file);
}

}  // namespace

SyncedFiles::SyncedFiles() { files_of_thread = this; }
SyncedFiles::~SyncedFiles() { files_of_thread = nullptr; }

void SyncedFiles::note(int file) {
  const auto path = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file));
  names_.insert(path.filename().string());
}

}  // namespace lode::test

/// Replaces the system's fdatasync(); records the file and forwards the call.
extern "C" int fdatasync(int file) {
  lode::test::noteSync(file);
  static const auto system = reinterpret_cast<decltype(&fdatasync)>(dlsym(RTLD_NEXT, "fdatasync"));
  return system(file);
}
