#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "client/app/window/input.h"
#include "client/app/window/panel/panel_settings.h"
#include "client/render/image.h"

struct GLFWwindow;

namespace lode::app {

/// The one window of this program with its OpenGL 4.5 core context, current on the thread that made it.
/// All functions are for that thread, which must be the program's first.
class GlfwWindow {
 public:
  /// @throws Error kIo that says what is missing and what to do instead.
  GlfwWindow(uint32_t width_px, uint32_t height_px, const std::string& title);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  GLFWwindow* handle() const noexcept { return window_; }
  /// Size of the picture; 0 while the window is minimized.
  uint32_t widthPx() const noexcept;
  uint32_t heightPx() const noexcept;
  double contentScale() const noexcept;  ///< pixels for what is one pixel on a plain display

  bool shouldClose() const noexcept;
  void setTitle(const std::string& title);
  void copyToClipboard(const std::string& text);
  /// There is one with a mapping that GLFW knows; it makes no events.
  bool hasGamepad() const noexcept;
  /// Waits for events at most so long (0: not at all) and handles them.
  void handleEvents(double wait_s);
  /// From now on the mouse is not for the picture there, nor until a button is released that went down there.
  void cover(const std::optional<Covered>& covered) { covered_ = covered; }
  /// What the user did since the last call.
  Input takeInput();
  void swap();
  /// What was drawn and not yet swapped.
  render::Image readBack() const;

 private:
  struct Callbacks;
  void pressKey(int key, int modifiers);
  void typeSign(unsigned code);
  void moveTo(glm::dvec2 position);
  void pressButton(int button, bool is_down);
  void turnWheel(double steps);
  bool isCovered(const glm::dvec2& point) const { return covered_ && covered_->has(point); }
  render::FlyKeys heldKeys() const;
  void takeGamepad(Input& input);

  GLFWwindow* window_ = nullptr;
  Input pending_;
  std::optional<Covered> covered_;
  bool pressed_covered_ = false;  ///< the button last pressed, where it went down
  bool is_repeated_ = false;      ///< the key last handled is held down
  glm::dvec2 pointer_{0}, pressed_at_{0}, clicked_at_{0};
  unsigned pad_buttons_ = 0;  ///< that were held at the last look, by GLFW's numbers
  double handled_s_ = 0;      ///< when events were last looked at
  double unattended_s_ = 0;   ///< in all, between looks: events bear no times of their own
  double clicked_s_ = -1e9, clicked_unattended_s_ = 0;  ///< at the last click
  double to_px_ = 1;                                    ///< pixels of the picture for one unit of the pointer
};

}  // namespace lode::app
