#pragma once

#include <set>
#include <string>

namespace lode::test {

/// While it lives, notes the names of the files that its thread brings to the disk: this program has an
/// fdatasync() of its own.
class SyncedFiles {
 public:
  SyncedFiles();
  ~SyncedFiles();
  SyncedFiles(const SyncedFiles&) = delete;
  SyncedFiles& operator=(const SyncedFiles&) = delete;

  void note(int file);
  const std::set<std::string, std::less<>>& names() const { return names_; }

 private:
  std::set<std::string, std::less<>> names_;
};

}  // namespace lode::test
