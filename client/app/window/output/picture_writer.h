#pragma once

#include <chrono>
#include <deque>
#include <exception>
#include <filesystem>
#include <future>
#include <optional>

#include "client/render/gl/image.h"

namespace lode::app {

/// A picture that the user asks for by a key. It is taken when the window is at rest, so that it has the
/// detail of a resting camera and the panel's final text, but at the latest after kLongestWait.
class PictureRequest {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kLongestWait{2};

  void ask(TimePoint now) noexcept {
    if (!asked_) asked_ = now;
  }
  bool isOpen() const noexcept { return asked_.has_value(); }
  /// Call after each frame. @return true once for each request.
  bool take(bool is_at_rest, TimePoint now) noexcept {
    if (!asked_ || !(is_at_rest || now - *asked_ >= kLongestWait)) return false;
    asked_.reset();
    return true;
  }

 private:
  std::optional<TimePoint> asked_;
};

/// Writes pictures to PNG files on another thread, one after the other. Not thread safe.
class PictureWriter {
 public:
  /// Waits until all are written.
  ~PictureWriter() = default;

  /// Queues a picture; waits while eight are queued. Writes it at once if the system gives no thread.
  void write(std::filesystem::path file, render::Image image);

  struct Written {
    std::filesystem::path file;
    std::exception_ptr failure;  ///< an Error; null: the file is written
  };
  /// Returns the oldest picture not yet returned, if it is written or has failed.
  std::optional<Written> take();
  /// Waits until all are written, then does the same.
  std::optional<Written> waitAndTake();

 private:
  std::deque<std::shared_future<Written>> queued_;
};

}  // namespace lode::app
