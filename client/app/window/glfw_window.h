#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "client/app/camera/input.h"
#include "client/app/window/panel/panel_settings.h"
#include "client/render/gl/image.h"

struct GLFWwindow;

namespace lode::app {

/// The program's window with an OpenGL 4.5 core context. The context is current on the thread that created
/// the window. Create and use the window only on the main thread.
class GlfwWindow {
 public:
  /// Opens the window. @throws Error kIo if the system has no display or no OpenGL 4.5.
  GlfwWindow(uint32_t width_px, uint32_t height_px, const std::string& title);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  GLFWwindow* handle() const noexcept { return window_; }
  // The next two functions return the size of the picture; 0 while the window is minimized.
  uint32_t widthPx() const noexcept;
  uint32_t heightPx() const noexcept;
  /// Returns the ratio of the display's pixel density to the system's default density.
  double contentScale() const noexcept;

  bool shouldClose() const noexcept;
  void setTitle(const std::string& title);
  /// Switches between full screen, on the monitor with the window's centre, and the former window. Does
  /// nothing without a monitor.
  void toggleFullScreen();
  void copyToClipboard(const std::string& text);
  /// Returns true if a gamepad that GLFW can map is connected. Gamepads send no events, so poll them.
  bool hasGamepad() const noexcept;
  /// Waits for events, at most `wait_s`, and handles them.
  void handleEvents(double wait_s);
  /// Sets the area that the panel covers. Mouse input in this area, and drags that begin in it, do not move
  /// the camera.
  void cover(const std::optional<Covered>& covered) { covered_ = covered; }
  /// Returns the input since the last call.
  Input takeInput();
  void swap();
  /// Returns the picture in the back buffer. Call it after drawing and before swap().
  render::Image readBack() const;

 private:
  struct Callbacks;
  void pressKey(int key, int modifiers);
  void pressToolKey(int key, int modifiers);
  void releaseKey(int key);
  void typeSign(unsigned code);
  void moveTo(glm::dvec2 position);
  void pressButton(int button, bool is_down);
  void turnWheel(double steps);
  bool isCovered(const glm::dvec2& point) const { return covered_ && covered_->has(point); }
  FlyKeys heldKeys() const;
  void takeGamepad(Input& input);

  /// A rectangle of the desktop, in screen coordinates.
  struct Place {
    int x = 0, y = 0, width = 0, height = 0;
  };
  Place place() const;

  GLFWwindow* window_ = nullptr;
  Place windowed_;  ///< place of the window before full screen
  Input pending_;
  std::optional<Covered> covered_;
  bool pressed_covered_ = false;  ///< true while a mouse button that went down over the panel is held
  bool is_x_used_ = false;        ///< true if X is held for a drag, or was pressed with Shift
  bool is_repeated_ = false;      ///< true if the last key event was the repetition of a held key
  glm::dvec2 pointer_{0}, pressed_at_{0}, clicked_at_{0};
  unsigned pad_buttons_ = 0;  ///< bit mask of the gamepad buttons held at the last poll, in GLFW's order
  double handled_s_ = 0;      ///< time when handleEvents() last returned
  /// Total time spent outside handleEvents(). Needed to time double clicks, because events have no time
  /// stamps.
  double unattended_s_ = 0;
  double clicked_s_ = -1e9, clicked_unattended_s_ = 0;  ///< time and unattended_s_ at the last click
  double to_px_ = 1;                                    ///< number of pixels per unit of pointer coordinates
};

}  // namespace lode::app
