#pragma once

#include <filesystem>

namespace lode::app {

/// Whether this user has seen the help, remembered by an empty file. A folder that cannot be written only
/// shows it again.
class FirstStart {
 public:
  /// @param folder  made when there is something to remember.
  explicit FirstStart(std::filesystem::path folder);

  bool isHelpDue() const;
  void helpWasSeen() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace lode::app
