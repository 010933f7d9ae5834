#pragma once

#include <memory>

namespace lode::render {

/// An OpenGL 4.5 core context without a display or a window, current on the thread that made it until it is
/// destroyed on that thread.
class OffscreenContext {
 public:
  /// @throws Error kIo that says what is missing and what to install.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lode::render
