#pragma once

#include <filesystem>

namespace lode::app {

/// Remembers by an empty file whether this user has seen the help. If the folder is not writable, the help is
/// shown again.
class FirstStart {
 public:
  /// @param folder  created by helpWasSeen().
  explicit FirstStart(std::filesystem::path folder);

  bool isHelpDue() const;
  void helpWasSeen() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace lode::app
