#pragma once

#include <string>

namespace lode::app {

/// What a file is called that a key writes: "lodestream-20261125-140039.png" for the ending "png".
std::string timedName(const std::string& ending);

}  // namespace lode::app
