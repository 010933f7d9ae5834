#pragma once

#include "client/app/camera/cameras.h"
namespace lode::app {

/// Returns the width of the help about keys and mouse in the current window.
float helpWidthPx(CameraKind camera);
/// Draws the help into the current ImGui window. @param width_px  helpWidthPx().
void drawHelp(CameraKind camera, float width_px);

}  // namespace lode::app
