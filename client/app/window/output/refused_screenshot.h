#pragma once

#include "client/app/cli/common_options.h"
#include "client/app/window/scene/viewed_scene.h"

namespace lode::app {

/// Says why there is no screenshot of a view and what to do. @throws Error always.
[[noreturn]] void refuseScreenshot(const ViewedScene& scene, const CommonOptions& options);

}  // namespace lode::app
