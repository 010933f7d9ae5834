#pragma once

#include <memory>

#include "client/app/cli/common_options.h"
#include "client/app/window/exhibit.h"

namespace lode::app {

/// The model or the scene that a target names; it begins to open. @throws Error.
std::unique_ptr<Exhibit> exhibitOf(const CommonOptions& common, Lacking lacking);

}  // namespace lode::app
