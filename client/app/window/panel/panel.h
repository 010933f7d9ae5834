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
#include "client/app/window/panel/panel_letters.h"
#include "client/app/window/panel/panel_scroll.h"
#include "client/app/window/panel/panel_settings.h"

struct GLFWwindow;

namespace lode::app {

/// The panel over the picture. Made after the window and its callbacks, destroyed before it, used on its
/// thread.
class Panel {
 public:
  explicit Panel(GLFWwindow* window);
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;

  /// For what is drawn next. Another scale or letters than before take a moment.
  /// @param scale  of the text: 1 for a plain display.
  void prepare(double scale, const PanelContent& content);
  /// Draws into the window's own framebuffer.
  void draw(const PanelContent& content);
  /// Where it takes the mouse since it was drawn last.
  const std::optional<Covered>& covered() const noexcept { return covered_; }
  /// What the wheel scrolls at a place of the picture since it was drawn last; null: nothing.
  PanelScroll* scrolledAt(const glm::dvec2& place_px);
  /// What the user has set there since the last call.
  std::optional<Settings> takeSettings() { return std::exchange(changed_, std::nullopt); }

 private:
  void layOut(const PanelContent& content);
  void drawOpen(const PanelContent& content) const;
  void drawParts(const PanelContent& content, std::span<const Figure> figures, const std::vector<bool>& shown,
                 std::span<const render::LegendEntry> legend) const;

  static constexpr size_t kFramesShown = 120;
  std::array<float, kFramesShown> frames_ms_{};  ///< a ring
  size_t next_frame_ = 0;
  float scale_ = 0;
  PanelLetters letters_;
  std::optional<Covered> covered_;
  PanelScroll scroll_, help_scroll_;
  std::optional<Settings> changed_;
};

}  // namespace lode::app
