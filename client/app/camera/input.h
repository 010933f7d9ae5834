#pragma once

#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/app/camera/cameras.h"
#include "client/core/view/framing.h"

namespace lode::app {

/// User input since the last frame. Distances and positions are in pixels of the picture, y down.
struct Input {
  glm::dvec2 turned_px{0};  ///< distance dragged with the left button
  /// Distance dragged with the right or middle button, or with the left button and Shift.
  glm::dvec2 shifted_px{0};
  glm::dvec2 light_px{0};    ///< distance dragged with the left button while L is held
  glm::dvec2 section_px{0};  ///< distance dragged with the left button while X is held
  double wheel = 0;          ///< wheel steps, forward is positive
  glm::dvec2 pointer_px{0};  ///< current pointer position
  bool pressed = false;      ///< a mouse button went down
  glm::dvec2 pressed_px{0};  ///< pointer position at the moment the button went down
  bool clicked = false;      ///< the left button went down and up while the pointer stayed in place
  /// True for the second click of a double click. The first click has set `clicked` in this frame or in an
  /// earlier frame.
  bool double_clicked = false;
  FlyKeys fly;             ///< movement by the keys held down now and by the gamepad
  glm::dvec2 pad_turn{0};  ///< right stick of the gamepad, -1 to 1: x to the right, y down

  // Keys that were pressed since the last frame. Two presses of a toggle key cancel each other.
  bool reset_camera = false;
  bool toggle_wireframe = false, toggle_panel = false, toggle_help = false, toggle_settings = false;
  bool toggle_full_screen = false, toggle_messages = false;
  bool any_key = false;  ///< a key other than Shift, Ctrl, Alt or Super was pressed
  int bookmark = 0;      ///< 1 to 9: number of the bookmark to use; 0: none
  /// True stores the camera in the bookmark; false moves the camera to the bookmark.
  bool set_bookmark = false;
  int next_measure = 0;  ///< number of steps through the kinds of measurements
  bool keep_measure = false, drop_measure = false, save_measures = false;
  int next_section = 0;  ///< number of steps through the section planes and none
  bool flip_section = false;
  bool hide_model = false, isolate_model = false;  ///< the model under the pointer
  int next_clay = 0;                               ///< number of steps through clay, matcap and surface
  bool toggle_parallel = false;                    ///< switch between perspective and parallel projection
  std::optional<core::Side> side;                  ///< side of the model to look at
  int next_camera = 0;                             ///< number of steps through the kinds of cameras
  int next_axis = 0;                               ///< number of steps through the up axes
  int next_show = 0;  ///< number of steps through the colour modes; negative steps go back
  int finer = 0;      ///< number of steps by which to lower the threshold; negative steps raise it
  bool enter = false;
  bool screenshot = false, copy = false, record = false, quit = false;
  /// Q was pressed. Q quits if the scene failed to open, and otherwise moves the camera down.
  bool quit_where_idle = false;

  std::string dropped;  ///< path of a file that was dropped on the window; empty: none

  bool over_panel = false;  ///< the mouse was used on the panel instead of the picture
  bool damaged = false;     ///< the system has lost the window's contents; draw them again

  bool any() const noexcept {
    return turned_px != glm::dvec2(0) || light_px != glm::dvec2(0) || section_px != glm::dvec2(0) ||
           shifted_px != glm::dvec2(0) || wheel != 0 || fly.right != 0 || fly.up != 0 || fly.forward != 0 ||
           pad_turn != glm::dvec2(0) || next_camera != 0 || reset_camera || next_axis != 0 ||
           toggle_wireframe || toggle_panel || next_show != 0 || bookmark != 0 || finer != 0 || screenshot ||
           copy || record || pressed || clicked || any_key || quit || over_panel || !dropped.empty();
  }
};

/// Returns the input without keys that are typed into a text box. Keeps Enter, Esc, F11, a dropped file and
/// `damaged`. Pure.
Input withoutTyping(const Input& input);

/// Positions of a gamepad's sticks and triggers as GLFW maps them, from -1 to 1. The y of a stick points
/// down. A released trigger is at -1.
struct PadAxes {
  glm::dvec2 left{0}, right{0};
  double left_trigger = -1, right_trigger = -1;
};

/// Camera motion by a gamepad. The left stick moves the camera, the right stick turns it, the left trigger
/// lowers it, and the right trigger raises it.
struct PadMotion {
  FlyKeys move;        ///< motion; `fast` is not set
  glm::dvec2 turn{0};  ///< turn from -1 to 1; x to the right, y down
};

/// Converts stick and trigger positions to camera motion, with a dead zone and a quadratic curve. Half of the
/// travel outside the dead zone gives a quarter of the speed. Pure.
PadMotion motionOf(const PadAxes& axes) noexcept;

}  // namespace lode::app
