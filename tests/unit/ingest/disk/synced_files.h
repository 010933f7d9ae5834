#pragma once

#include <set>
#include <string>

namespace lode::test {

/// Records the names of files that the current thread syncs during this object's lifetime. The test program
/// replaces fdatasync().
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
