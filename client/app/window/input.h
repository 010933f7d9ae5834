#pragma once

#include <glm/glm.hpp>

#include "client/app/window/camera/cameras.h"

namespace lode::app {

/// What the user did since the last frame, in pixels of the picture, y down.
struct Input {
  glm::dvec2 turned_px{0};      ///< dragged with the left button
  glm::dvec2 shifted_px{0};     ///< dragged with the right or middle button, or with Shift
  double wheel = 0;             ///< steps forward
  glm::dvec2 pointer_px{0};     ///< where the pointer is
  bool pressed = false;         ///< a button went down
  glm::dvec2 pressed_px{0};     ///< where one did last: the pointer may have gone on since
  bool clicked = false;         ///< the left button went down and up where the pointer is
  bool double_clicked = false;  ///< and again; the first of the two is `clicked`, in this frame or one before
  render::FlyKeys fly;          ///< held down now
  glm::dvec2 pad_turn{0};       ///< by a gamepad's stick, -1 to 1: to the right, down

  // Keys that were pressed; what is toggled twice stays as it was.
  bool reset_camera = false;
  bool toggle_wireframe = false, toggle_panel = false, toggle_help = false, toggle_settings = false;
  bool any_key = false;       ///< of all that there are
  int bookmark = 0;           ///< 1 to 9: go there,
  bool set_bookmark = false;  ///< or put it here
  int next_camera = 0;        ///< steps among the kinds of cameras,
  int next_axis = 0;          ///< among the axes that may be up,
  int next_show = 0;          ///< and among what can be shown, negative for back
  int finer = 0;              ///< steps of the threshold, negative for coarser
  bool screenshot = false, copy = false, record = false, quit = false;
  bool quit_where_idle = false;  ///< the key that flies down, where nothing flies

  bool over_panel = false;  ///< what the mouse did was for what covers the picture
  bool damaged = false;     ///< the window's picture is gone: the system's doing, not the user's

  bool any() const noexcept {
    return turned_px != glm::dvec2(0) || shifted_px != glm::dvec2(0) || wheel != 0 || fly.right != 0 ||
           fly.up != 0 || fly.forward != 0 || pad_turn != glm::dvec2(0) || next_camera != 0 || reset_camera ||
           next_axis != 0 || toggle_wireframe || toggle_panel || next_show != 0 || bookmark != 0 ||
           finer != 0 || screenshot || copy || record || pressed || clicked || any_key || quit || over_panel;
  }
};

}  // namespace lode::app
