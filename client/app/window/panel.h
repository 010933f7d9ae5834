#pragma once

#include <array>
#include <cstddef>

#include "client/app/window/panel_content.h"

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

  /// Of the text: 1 for a plain display. Another one than before takes a moment.
  void setScale(double scale);
  /// Draws into the window's own framebuffer.
  void draw(const PanelContent& content);
  bool wantsMouse() const;
  bool wantsKeyboard() const;

 private:
  void drawOpen(const PanelContent& content) const;

  static constexpr size_t kFramesShown = 120;
  std::array<float, kFramesShown> frames_ms_{};  ///< a ring
  size_t next_frame_ = 0;
  float scale_ = 0;
};

}  // namespace lode::app
