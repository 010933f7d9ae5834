#pragma once

#include <string>
#include <string_view>

namespace lode::app {

/// "sort, 3 of 6": a stage of a build, as its progress names it, and its place among them. What only some
/// models need counts as of the stage before it. A name that is not known is left as it is.
std::string describeStage(std::string_view stage);

}  // namespace lode::app
