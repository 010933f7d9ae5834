#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/window/panel/panel_content.h"
#include "client/app/window/panel/panel_figures.h"
#include "client/app/window/panel/panel_font.h"
#include "client/app/window/panel/panel_settings.h"
#include "client/app/window/panel/panel_window.h"
#include "client/app/window/panel/start_page.h"

struct GLFWwindow;

namespace lode::app {

/// The panel over the picture. Create the panel after the window has set its callbacks, and destroy the panel
/// before the window. Use it only on the window's thread.
class Panel {
 public:
  explicit Panel(GLFWwindow* window);
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;

  /// Prepares the font for drawMarksOf(). Reloads it, which is slow, if the scale has changed or the content
  /// has new characters. @param scale  scale of the text, 1 on a standard display.
  void prepare(double scale, const PanelContent& content);
  /// Lays out everything, then draws the marks (picked points, axes and scale bar) into the window's
  /// framebuffer. Saved pictures have these marks, but not the panel, the help and the settings.
  void drawMarksOf(const PanelContent& content);
  /// Draws the panel, the help and the settings. Call it after drawMarksOf(), for the same content.
  void drawWindows() { drawLists(false); }
  /// Returns the area of the settings, which captures the mouse; nothing if the last drawMarksOf() laid out
  /// no settings.
  const std::optional<Covered>& covered() const noexcept { return covered_; }
  /// Returns the panel or the help if it covers a pixel of the picture and can scroll, else null. The last
  /// drawMarksOf() determines their place. @param place_px  position in the picture, in pixels.
  PanelScroll* scrolledAt(const glm::dvec2& place_px);
  /// Returns the settings if the user has changed them since the last call.
  std::optional<Settings> takeSettings() { return std::exchange(changed_, std::nullopt); }
  /// Returns the target that the user has chosen on the start page since the last call; empty: none.
  std::string takeTarget() { return std::exchange(chosen_, {}); }

 private:
  void layOut(const PanelContent& content);
  void layOutStart(const StartPage& page);
  void drawLeft(const PanelContent& content, float width_px, PanelScroll& scroll) const;
  static void drawLists(bool marks);
  void drawOpen(const PanelContent& content) const;
  void drawParts(const PanelContent& content, std::span<const Figure> figures, const std::vector<bool>& shown,
                 std::span<const render::LegendEntry> legend) const;

  static constexpr size_t kFramesShown = 120;
  std::array<float, kFramesShown> frames_ms_{};  ///< ring buffer of the latest frame times
  size_t next_frame_ = 0;
  float scale_ = 0;
  PanelCharacters characters_;
  std::optional<Covered> covered_;
  PanelScroll scroll_, help_scroll_;
  std::optional<Settings> changed_;
  PathText path_{};  ///< text of the start page's path box
  std::string chosen_;
};

}  // namespace lode::app
