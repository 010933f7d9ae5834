#pragma once

#include <memory>

#include "client/app/cli/common_options.h"
#include "client/app/window/scene/viewer_content.h"

namespace lode::app {

/// The model or the scene that a target names; it begins to open. @throws Error.
std::unique_ptr<ViewerContent> contentOf(const CommonOptions& common, Lacking lacking);

}  // namespace lode::app
