#pragma once

#include <chrono>
#include <deque>
#include <exception>
#include <filesystem>
#include <future>
#include <optional>

#include "client/render/gl/image.h"

namespace lode::app {

/// A picture that the user requests by a key. The picture is due when the window is at rest, so that it shows
/// full detail and the panel's final text. If the window does not come to rest, the picture is due after
/// kLongestWait.
class PictureRequest {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kLongestWait{2};

  void ask(TimePoint now) noexcept {
    if (!asked_) asked_ = now;
  }
  bool isOpen() const noexcept { return asked_.has_value(); }
  /// Ends the request if its picture is due. Call it after each frame. @return true if the picture is due.
  bool take(bool is_at_rest, TimePoint now) noexcept {
    if (!asked_ || !(is_at_rest || now - *asked_ >= kLongestWait)) return false;
    asked_.reset();
    return true;
  }

 private:
  std::optional<TimePoint> asked_;
};

/// Writes pictures to PNG files on other threads, one file after the other. Not thread safe.
class PictureWriter {
 public:
  /// Waits until all pictures are written.
  ~PictureWriter() = default;

  /// Queues a picture. Waits while eight pictures are queued. If the system cannot start a thread, writes the
  /// picture at once.
  void write(std::filesystem::path file, render::Image image);

  struct Written {
    std::filesystem::path file;
    std::exception_ptr failure;  ///< reason why the file could not be written; null on success
  };
  /// Returns the oldest result that was not returned yet. Returns nothing if there is no further picture or
  /// it is still being written.
  std::optional<Written> take();
  /// Waits until all pictures are written, then returns take().
  std::optional<Written> waitAndTake();

 private:
  std::deque<std::shared_future<Written>> queued_;
};

}  // namespace lode::app
