#pragma once

#include <memory>

namespace lode::render {

/// An OpenGL 4.5 core context without a display or a window. The context is current on the thread that
/// creates it, until the same thread destroys it.
class OffscreenContext {
 public:
  /// @throws Error kIo that says what is missing and which package to install.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lode::render
