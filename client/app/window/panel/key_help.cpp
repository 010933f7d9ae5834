#include "client/app/window/panel/key_help.h"

#include <array>

namespace lode::app {
namespace {

constexpr std::array kOrbitHelp{
    KeyHelp{"drag", "turn about what is under the pointer"},
    KeyHelp{"right drag", "shift"},
    KeyHelp{"wheel  W  S", "come nearer to what is under the pointer"},
    KeyHelp{"double click", "go there"},
};

constexpr std::array kFlyHelp{
    KeyHelp{"drag, right drag", "look around"},
    KeyHelp{"W A S D", "move"},
    KeyHelp{"Q  E", "down and up"},
    KeyHelp{"Shift", "four times as fast"},
    KeyHelp{"wheel", "faster or slower"},
    KeyHelp{"double click", "goes there in orbit alone"},
};

constexpr std::array kWalkHelp{
    KeyHelp{"drag, right drag", "look around"}, KeyHelp{"W A S D", "walk"},
    KeyHelp{"Q  E", "smaller and taller"},      KeyHelp{"Shift", "four times as fast"},
    KeyHelp{"wheel", "faster or slower"},       KeyHelp{"double click", "goes there in orbit alone"},
};

constexpr std::array kCommonHelp{
    KeyHelp{"Tab", "orbit, fly, or walk from where the pointer is"},
    KeyHelp{"R  U", "the first view again; another side up"},
    KeyHelp{"1 to 9", "go to a bookmark; with Ctrl: set it"},
    KeyHelp{"click  C", "measure; copy what the panel says of it"},
    KeyHelp{"V  F", "other views; wireframe"},
    KeyHelp{"+  -", "finer or coarser"},
    KeyHelp{"P  F12", "record the camera; save a picture"},
    KeyHelp{"O", "settings, for the mouse"},
    KeyHelp{"H  F1", "hide the panel; this help"},
    KeyHelp{"Esc", "leave"},
};

}  // namespace

std::span<const KeyHelp> cameraHelp(CameraKind camera) noexcept {
  switch (camera) {
    case CameraKind::kFly:
      return kFlyHelp;
    case CameraKind::kWalk:
      return kWalkHelp;
    case CameraKind::kOrbit:
      break;
  }
  return kOrbitHelp;
}

std::span<const KeyHelp> commonHelp() noexcept { return kCommonHelp; }

}  // namespace lode::app
