#include "client/app/window/glfw_window.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "client/render/gl/framebuffer.h"
#include "common/error.h"

namespace lode::app {
namespace {

/// Largest distance that the pointer may move during a click, in pointer units.
constexpr double kClickReach = 4;
/// Longest time between the clicks of a double click, excluding the time spent on frames.
constexpr double kDoubleClickS = 0.35;
/// Longest time between the clicks of a double click, including the time spent on frames.
constexpr double kLongestDoubleClickS = 1.2;

/// Makes GLFW skip Wayland if the session has no folder for its sockets. Wayland's library would print
/// "error: XDG_RUNTIME_DIR is invalid or not set in the environment." on stderr, then GLFW would use X11
/// anyway. GLFW before 3.4 does not try Wayland.
void skipUselessWayland() {
#ifdef GLFW_PLATFORM
  const char* const folder = std::getenv("XDG_RUNTIME_DIR");
  const char* const screen = std::getenv("DISPLAY");
  const bool has_folder = folder != nullptr && folder[0] == '/',
             has_x11 = screen != nullptr && screen[0] != 0;
  if (!has_folder && has_x11) glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
}

/// Returns the side of the model that a key shows: Alt and a digit, or 1, 3 and 7 of the numeric keypad, with
/// Ctrl for the opposite side.
std::optional<core::Side> sideOf(int key, int modifiers) {
  using enum core::Side;
  const bool is_opposite = (modifiers & GLFW_MOD_CONTROL) != 0;
  if (key == GLFW_KEY_KP_1) return is_opposite ? kBack : kFront;
  if (key == GLFW_KEY_KP_3) return is_opposite ? kLeft : kRight;
  if (key == GLFW_KEY_KP_7) return is_opposite ? kBottom : kTop;
  const bool is_digit = key >= GLFW_KEY_1 && key < GLFW_KEY_1 + static_cast<int>(core::kSideNames.size());
  if (!is_digit || (modifiers & GLFW_MOD_ALT) == 0) return std::nullopt;
  return static_cast<core::Side>(key - GLFW_KEY_1);
}

std::string lastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "no reason given";
}

/// Returns the monitor that shows a point of the desktop, or else the primary monitor; null if there is none.
GLFWmonitor* monitorAt(int x, int y) {
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* const mode = glfwGetVideoMode(monitors[i]);
    int left = 0, top = 0;
    glfwGetMonitorPos(monitors[i], &left, &top);
    const bool is_within =
        mode != nullptr && x >= left && x < left + mode->width && y >= top && y < top + mode->height;
    if (is_within) return monitors[i];
  }
  return glfwGetPrimaryMonitor();
}

}  // namespace

/// Callbacks that GLFW calls from handleEvents().
struct GlfwWindow::Callbacks {
  static GlfwWindow& of(GLFWwindow* window) {
    return *static_cast<GlfwWindow*>(glfwGetWindowUserPointer(window));
  }
  static void key(GLFWwindow* window, int key, int, int action, int modifiers) {
    of(window).is_repeated_ = action == GLFW_REPEAT;
    if (action == GLFW_PRESS) of(window).pressKey(key, modifiers);
    if (action == GLFW_RELEASE) of(window).releaseKey(key);
  }
  static void sign(GLFWwindow* window, unsigned code) { of(window).typeSign(code); }
  static void pointer(GLFWwindow* window, double x, double y) { of(window).moveTo({x, y}); }
  static void button(GLFWwindow* window, int button, int action, int) {
    of(window).pressButton(button, action == GLFW_PRESS);
  }
  static void refresh(GLFWwindow* window) { of(window).pending_.damaged = true; }
  /// Takes the first of the dropped files.
  static void drop(GLFWwindow* window, int count, const char** paths) {
    if (count > 0) of(window).pending_.dropped = paths[0];
  }
  static void wheel(GLFWwindow* window, double, double y) { of(window).turnWheel(y); }
};

GlfwWindow::GlfwWindow(uint32_t width_px, uint32_t height_px, const std::string& title) {
  skipUselessWayland();
  if (glfwInit() == GLFW_FALSE) {
    throw Error(ErrorCode::kIo, "no window can be opened (" + lastGlfwError() +
                                    "): run this where there is a display, or use `lodestream render`");
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = glfwCreateWindow(static_cast<int>(width_px), static_cast<int>(height_px), title.c_str(), nullptr,
                             nullptr);
  if (window_ == nullptr) {
    const std::string why = lastGlfwError();
    glfwTerminate();
    throw Error(ErrorCode::kIo, "no window with OpenGL 4.5 can be opened (" + why +
                                    "): update the graphics driver, or use `lodestream render`");
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, Callbacks::key);
  glfwSetCharCallback(window_, Callbacks::sign);
  glfwSetCursorPosCallback(window_, Callbacks::pointer);
  glfwSetMouseButtonCallback(window_, Callbacks::button);
  glfwSetScrollCallback(window_, Callbacks::wheel);
  glfwSetDropCallback(window_, Callbacks::drop);
  glfwSetWindowRefreshCallback(window_, Callbacks::refresh);
}

GlfwWindow::~GlfwWindow() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

uint32_t GlfwWindow::widthPx() const noexcept {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  return static_cast<uint32_t>(width);
}

uint32_t GlfwWindow::heightPx() const noexcept {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  return static_cast<uint32_t>(height);
}

double GlfwWindow::contentScale() const noexcept {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window_, &x, &y);
  return y > 0 ? y : 1;
}

bool GlfwWindow::shouldClose() const noexcept { return glfwWindowShouldClose(window_) == GLFW_TRUE; }

void GlfwWindow::setTitle(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

GlfwWindow::Place GlfwWindow::place() const {
  Place place;
  glfwGetWindowPos(window_, &place.x, &place.y);
  glfwGetWindowSize(window_, &place.width, &place.height);
  return place;
}

void GlfwWindow::toggleFullScreen() {
  if (glfwGetWindowMonitor(window_) != nullptr) {
    glfwSetWindowMonitor(window_, nullptr, windowed_.x, windowed_.y, windowed_.width, windowed_.height,
                         GLFW_DONT_CARE);
    return;
  }
  const Place now = place();
  GLFWmonitor* const monitor = monitorAt(now.x + now.width / 2, now.y + now.height / 2);
  const GLFWvidmode* const mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  if (mode == nullptr) return;
  windowed_ = now;
  // The window stays visible if a window on another monitor gets the focus.
  glfwSetWindowAttrib(window_, GLFW_AUTO_ICONIFY, GLFW_FALSE);
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void GlfwWindow::copyToClipboard(const std::string& text) { glfwSetClipboardString(window_, text.c_str()); }

void GlfwWindow::handleEvents(double wait_s) {
  unattended_s_ += glfwGetTime() - handled_s_;
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  to_px_ = height > 0 ? static_cast<double>(heightPx()) / height : 1;
  if (wait_s > 0) {
    glfwWaitEventsTimeout(wait_s);
  } else {
    glfwPollEvents();
  }
  handled_s_ = glfwGetTime();
}

void GlfwWindow::pressKey(int key, int modifiers) {
  if (key < GLFW_KEY_LEFT_SHIFT) pending_.any_key = true;  // modifier keys do not count
  if (const auto side = sideOf(key, modifiers)) {
    pending_.side = side;
    return;
  }
  if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9) {
    pending_.bookmark = key - GLFW_KEY_1 + 1;
    pending_.set_bookmark = (modifiers & GLFW_MOD_CONTROL) != 0;
  }
  switch (key) {
    case GLFW_KEY_TAB:
      ++pending_.next_camera;
      break;
    case GLFW_KEY_R:
      pending_.reset_camera = true;
      break;
    case GLFW_KEY_U:
      ++pending_.next_axis;
      break;
    case GLFW_KEY_F:
      // Two presses within one frame cancel each other.
      pending_.toggle_wireframe = !pending_.toggle_wireframe;
      break;
    case GLFW_KEY_V:
      pending_.next_show += (modifiers & GLFW_MOD_SHIFT) != 0 ? -1 : 1;
      break;
    case GLFW_KEY_O:
      pending_.toggle_settings = !pending_.toggle_settings;
      break;
    case GLFW_KEY_F1:
      pending_.toggle_help = !pending_.toggle_help;
      break;
    case GLFW_KEY_H:
      pending_.toggle_panel = !pending_.toggle_panel;
      break;
    case GLFW_KEY_N:
    case GLFW_KEY_KP_5:
      pending_.toggle_parallel = !pending_.toggle_parallel;
      break;
    case GLFW_KEY_M:
      pending_.toggle_messages = !pending_.toggle_messages;
      break;
    case GLFW_KEY_F11:
      pending_.toggle_full_screen = !pending_.toggle_full_screen;
      break;
    case GLFW_KEY_F12:
      pending_.screenshot = true;
      break;
    case GLFW_KEY_P:
      pending_.record = !pending_.record;
      break;
    case GLFW_KEY_C:
      pending_.copy = true;
      break;
    case GLFW_KEY_Q:
      pending_.quit_where_idle = true;
      break;
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
      pending_.enter = true;
      break;
    case GLFW_KEY_ESCAPE:
      pending_.quit = true;
      break;
    default:
      pressToolKey(key, modifiers);
      break;
  }
}

/// Handles the keys of measurements, models, sections and clay.
void GlfwWindow::pressToolKey(int key, int modifiers) {
  if ((modifiers & GLFW_MOD_CONTROL) != 0) return;  // Ctrl+Z means something else elsewhere
  switch (key) {
    case GLFW_KEY_K:
      if ((modifiers & GLFW_MOD_SHIFT) != 0)
        ++pending_.next_measure;
      else
        pending_.keep_measure = true;
      break;
    case GLFW_KEY_Z:
      ((modifiers & GLFW_MOD_SHIFT) != 0 ? pending_.isolate_model : pending_.hide_model) = true;
      break;
    case GLFW_KEY_BACKSPACE:
      pending_.drop_measure = true;
      break;
    case GLFW_KEY_J:
      pending_.save_measures = true;
      break;
    case GLFW_KEY_X:
      // Without Shift, the key acts when it is released, unless it was held for a drag.
      is_x_used_ = (modifiers & GLFW_MOD_SHIFT) != 0;
      if (is_x_used_) pending_.flip_section = !pending_.flip_section;
      break;
    case GLFW_KEY_G:
      ++pending_.next_clay;
      break;
    default:
      break;
  }
}

void GlfwWindow::releaseKey(int key) {
  if (key != GLFW_KEY_X || is_x_used_) return;
  ++pending_.next_section;
  pending_.any_key = true;
}

/// Handles a typed character. pressKey() cannot handle these characters, because their keys depend on the
/// keyboard layout. GLFW reports the key before the character, so is_repeated_ is up to date.
void GlfwWindow::typeSign(unsigned code) {
  if (is_repeated_) return;
  if (code == '?') pending_.toggle_help = !pending_.toggle_help;
  if (code == '+' || code == '=') ++pending_.finer;
  if (code == '-') --pending_.finer;
}

void GlfwWindow::moveTo(glm::dvec2 position) {
  const glm::dvec2 moved = (position - pointer_) * to_px_;
  const bool was_covered = isCovered(pointer_);
  pointer_ = position;
  if (was_covered || isCovered(position) || pressed_covered_) pending_.over_panel = true;
  if (pressed_covered_) return;
  const auto held = [&](int button) { return glfwGetMouseButton(window_, button) == GLFW_PRESS; };
  const bool shift = glfwGetKey(window_, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS;
  const bool left = held(GLFW_MOUSE_BUTTON_LEFT);
  if (held(GLFW_MOUSE_BUTTON_RIGHT) || held(GLFW_MOUSE_BUTTON_MIDDLE) || (left && shift)) {
    pending_.shifted_px += moved;
  } else if (left && glfwGetKey(window_, GLFW_KEY_L) == GLFW_PRESS) {
    pending_.light_px += moved;
  } else if (left && glfwGetKey(window_, GLFW_KEY_X) == GLFW_PRESS) {
    pending_.section_px += moved;
    is_x_used_ = true;
  } else if (left) {
    pending_.turned_px += moved;
  }
}

void GlfwWindow::turnWheel(double steps) {
  if (isCovered(pointer_))
    pending_.over_panel = true;
  else
    pending_.wheel += steps;
}

void GlfwWindow::pressButton(int button, bool is_down) {
  const bool was_covered = std::exchange(pressed_covered_, is_down && isCovered(pointer_));
  if (was_covered || pressed_covered_) {
    pending_.over_panel = true;
    return;
  }
  if (is_down) {
    pressed_at_ = pointer_;
    pending_.pressed = true;
    return;
  }
  if (button != GLFW_MOUSE_BUTTON_LEFT || glm::distance(pointer_, pressed_at_) > kClickReach) return;
  const double since_s = glfwGetTime() - clicked_s_;
  const double attended_s = since_s - (unattended_s_ - clicked_unattended_s_);
  const bool is_there_again = glm::distance(pointer_, clicked_at_) <= kClickReach;
  pending_.double_clicked = is_there_again && attended_s < kDoubleClickS && since_s < kLongestDoubleClickS;
  pending_.clicked = pending_.clicked || !pending_.double_clicked;
  clicked_at_ = pointer_;
  clicked_s_ = pending_.double_clicked ? -1e9 : glfwGetTime();
  clicked_unattended_s_ = unattended_s_;
}

FlyKeys GlfwWindow::heldKeys() const {
  const auto held = [&](int key) { return glfwGetKey(window_, key) == GLFW_PRESS ? 1.0 : 0.0; };
  return {.right = held(GLFW_KEY_D) - held(GLFW_KEY_A),
          .up = held(GLFW_KEY_E) - held(GLFW_KEY_Q),
          .forward = held(GLFW_KEY_W) - held(GLFW_KEY_S),
          .fast = held(GLFW_KEY_LEFT_SHIFT) > 0};
}

bool GlfwWindow::hasGamepad() const noexcept { return glfwJoystickIsGamepad(GLFW_JOYSTICK_1) == GLFW_TRUE; }

/// Adds the gamepad's sticks and buttons to the input. The right bumper acts as Shift, A switches to the next
/// kind of camera, Y resets the view, X switches to the next colour mode, and Start opens the help.
void GlfwWindow::takeGamepad(Input& input) {
  GLFWgamepadstate pad;
  if (!hasGamepad() || glfwGetGamepadState(GLFW_JOYSTICK_1, &pad) == GLFW_FALSE) return;
  const float* const axes = pad.axes;
  const PadMotion motion =
      motionOf({.left = {axes[GLFW_GAMEPAD_AXIS_LEFT_X], axes[GLFW_GAMEPAD_AXIS_LEFT_Y]},
                .right = {axes[GLFW_GAMEPAD_AXIS_RIGHT_X], axes[GLFW_GAMEPAD_AXIS_RIGHT_Y]},
                .left_trigger = axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER],
                .right_trigger = axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER]});
  input.pad_turn = motion.turn;
  input.fly.right = std::clamp(input.fly.right + motion.move.right, -1.0, 1.0);
  input.fly.up = std::clamp(input.fly.up + motion.move.up, -1.0, 1.0);
  input.fly.forward = std::clamp(input.fly.forward + motion.move.forward, -1.0, 1.0);
  unsigned held = 0;
  for (int button = 0; button <= GLFW_GAMEPAD_BUTTON_LAST; ++button)
    if (pad.buttons[button] == GLFW_PRESS) held |= 1u << button;
  const auto isPressed = [&](int button) { return (held & ~pad_buttons_ & 1u << button) != 0; };
  input.fly.fast = input.fly.fast || (held & 1u << GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER) != 0;
  if (isPressed(GLFW_GAMEPAD_BUTTON_A)) ++input.next_camera;
  input.reset_camera = input.reset_camera || isPressed(GLFW_GAMEPAD_BUTTON_Y);
  input.toggle_help = input.toggle_help || isPressed(GLFW_GAMEPAD_BUTTON_START);
  if (isPressed(GLFW_GAMEPAD_BUTTON_X)) ++input.next_show;
  input.any_key = input.any_key || (held & ~pad_buttons_) != 0;
  pad_buttons_ = held;
}

Input GlfwWindow::takeInput() {
  Input input = std::exchange(pending_, {});
  input.pointer_px = pointer_ * to_px_;
  input.pressed_px = pressed_at_ * to_px_;
  input.fly = heldKeys();
  takeGamepad(input);
  return input;
}

void GlfwWindow::swap() { glfwSwapBuffers(window_); }

render::Image GlfwWindow::readBack() const {
  glNamedFramebufferReadBuffer(0, GL_BACK);
  return render::readFramebuffer(0, widthPx(), heightPx());
}

}  // namespace lode::app
