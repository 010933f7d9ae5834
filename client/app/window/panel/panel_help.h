#pragma once

#include "client/app/window/camera/cameras.h"
#include "client/app/window/panel/panel_window.h"

namespace lode::app {

/// Draws the help about keys and mouse at the centre of the picture.
void drawHelp(CameraKind camera, PanelScroll& scroll);

}  // namespace lode::app
