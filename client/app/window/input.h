#pragma once

#include <glm/glm.hpp>

#include "client/app/window/camera/cameras.h"

namespace lode::app {

/// User input since the last frame, in pixels of the picture, y down.
struct Input {
  glm::dvec2 turned_px{0};   ///< dragged with the left button
  glm::dvec2 shifted_px{0};  ///< dragged with the right or middle button, or with Shift
  double wheel = 0;          ///< steps forward
  glm::dvec2 pointer_px{0};  ///< pointer now
  bool pressed = false;      ///< a button went down
  glm::dvec2 pressed_px{0};  ///< pointer when it went down; it may have moved since
  bool clicked = false;      ///< the left button went down and up without moving
  bool double_clicked =
      false;               ///< clicked again; the first click is `clicked`, in this frame or an earlier one
  FlyKeys fly;             ///< held down now
  glm::dvec2 pad_turn{0};  ///< gamepad stick, -1 to 1: to the right, down

  // Keys that were pressed; two presses of a toggle cancel out.
  bool reset_camera = false;
  bool toggle_wireframe = false, toggle_panel = false, toggle_help = false, toggle_settings = false;
  bool any_key = false;       ///< any key was pressed
  int bookmark = 0;           ///< 1 to 9: go there
  bool set_bookmark = false;  ///< set the bookmark instead
  int next_camera = 0;        ///< steps through the kinds of cameras
  int next_axis = 0;          ///< steps through the up axes
  int next_show = 0;          ///< steps through the colour modes; negative: back
  int finer = 0;              ///< steps of the threshold; negative: coarser
  bool screenshot = false, copy = false, record = false, quit = false;
  bool quit_where_idle = false;  ///< Q: quits if no model is shown, else flies down

  bool over_panel = false;  ///< the mouse was used on the panel, which covers the picture
  bool damaged = false;     ///< the system lost the window's picture: redraw

  bool any() const noexcept {
    return turned_px != glm::dvec2(0) || shifted_px != glm::dvec2(0) || wheel != 0 || fly.right != 0 ||
           fly.up != 0 || fly.forward != 0 || pad_turn != glm::dvec2(0) || next_camera != 0 || reset_camera ||
           next_axis != 0 || toggle_wireframe || toggle_panel || next_show != 0 || bookmark != 0 ||
           finer != 0 || screenshot || copy || record || pressed || clicked || any_key || quit || over_panel;
  }
};

/// A gamepad's sticks and triggers as GLFW maps them: -1 to 1, sticks' y down, a released trigger at -1.
struct PadAxes {
  glm::dvec2 left{0}, right{0};
  double left_trigger = -1, right_trigger = -1;
};

/// Camera motion: the left stick moves, the triggers go down and up, the right stick turns.
struct PadMotion {
  FlyKeys move;        ///< without `fast`
  glm::dvec2 turn{0};  ///< -1 to 1: to the right, down
};

/// Applies a dead zone and a quadratic curve: half of a stick's travel is a quarter of the speed. Pure.
PadMotion motionOf(const PadAxes& axes) noexcept;

}  // namespace lode::app
