#pragma once

#include <array>
#include <string>
#include <vector>

namespace lode::app {

/// A target that the start page offers.
struct OfferedTarget {
  std::string target;
  bool is_missing = false;  ///< the file no longer exists

  bool operator==(const OfferedTarget&) const = default;
};

/// Content of the page that the window shows while it has no target.
struct StartPage {
  std::vector<OfferedTarget> recent;  ///< newest first
  std::string message;                ///< reason why the last target could not be opened; may be empty
  bool enter = false;                 ///< Enter was pressed, which opens the path in the box

  bool operator==(const StartPage&) const = default;
};

/// Text of the start page's path box, terminated by 0.
using PathText = std::array<char, 4096>;

/// Draws the start page in the middle of the window, within an ImGui frame.
/// @param path  text of the path box; user input changes it.
/// @return the target that the user has just chosen; empty: none.
std::string drawStartPage(const StartPage& page, PathText& path);

/// Returns a typed target without spaces around it, and with the user's home folder in place of "~". Pure.
/// @param home  the home folder; may be empty.
std::string typedTarget(std::string text, const std::string& home);

}  // namespace lode::app
