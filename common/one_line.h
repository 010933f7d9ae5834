#pragma once

#include <algorithm>
#include <cstdio>
#include <string>

namespace lode {

/// Says on one line of stderr what a program has to say.
inline void sayOnOneLine(const std::string& program, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "%s: %s\n", program.c_str(), message.c_str());
}

}  // namespace lode
