#pragma once

#include "client/app/window/camera/camera_kind.h"
#include "client/app/window/panel/panel_scroll.h"

namespace lode::app {

/// What keys do, in the middle of the picture.
void drawHelp(CameraKind camera, PanelScroll& scroll);

}  // namespace lode::app
