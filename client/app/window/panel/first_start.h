#pragma once

#include <filesystem>

namespace lode::app {

/// Remembers with an empty file that this user has seen the help. If the file cannot be written, the help
/// appears again at the next start.
class FirstStart {
 public:
  /// @param folder  folder of the empty file; helpWasSeen() creates the folder.
  explicit FirstStart(std::filesystem::path folder);

  /// Returns true if the user has not seen the help.
  bool isHelpDue() const;
  /// Notes that the user has seen the help.
  void helpWasSeen() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace lode::app
