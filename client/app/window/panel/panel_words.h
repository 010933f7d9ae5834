#pragma once

#include <string>

#include "client/app/window/panel/panel_content.h"

namespace lode::app {

/// Draws a progress bar with a text on it, or above it if the bar is too narrow for the text.
/// @param part  0 to 1.
void drawBar(double part, const std::string& text, float width_px);
/// Returns the height that drawBar() takes.
float barPx(const std::string& text, float width_px);
/// Returns the height of a text that wraps at a width.
float textPx(const std::string& text, float width_px);

/// Draws the texts at the top of the panel: the title and what the user should know now. Missing models,
/// warnings and the explanation of a colour mode are included only while the panel is visible.
void drawWords(const PanelContent& content, float width_px);
/// Returns the height that drawWords() takes.
float wordsPx(const PanelContent& content, float width_px);

/// Draws the step that the user waits for, with its progress.
void drawWaiting(const PanelContent& content, float width_px);

/// Returns a text as one line: without line breaks, and with an ending of "..." if it is wider than a width.
std::string onOneLine(std::string text, float width_px);

}  // namespace lode::app
