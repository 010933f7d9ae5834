#pragma once

#include <optional>

#include "client/app/window/panel/panel_settings.h"

namespace lode::app {

/// Scrolls a window of the panel's by the wheel where the picture's is too low for it.
class PanelScroll {
 public:
  /// By so many steps of the wheel, forward up, when it is laid out next.
  void turn(double steps) noexcept { steps_ += steps; }
  /// Before the window begins: it stays in the picture's.
  static void limit();
  /// Before the window ends.
  void follow();
  /// It is not shown.
  void leaveOut() noexcept { *this = {}; }
  /// Where it takes the wheel: nowhere if it is shown whole.
  const std::optional<Covered>& where() const noexcept { return where_; }

 private:
  double steps_ = 0;
  std::optional<Covered> where_;
};

}  // namespace lode::app
