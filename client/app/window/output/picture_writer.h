#pragma once

#include <deque>
#include <exception>
#include <filesystem>
#include <future>
#include <optional>
#include <string>

#include "client/render/image.h"

namespace lode::app {

/// Writes pictures to PNG files beside the thread that draws, one after the other. For one thread.
class PictureWriter {
 public:
  /// Waits until all are written.
  ~PictureWriter() = default;

  /// Begins to, once at most seven are under way. Where the system gives no thread it is done at once.
  void write(std::filesystem::path file, render::Image image);

  struct Written {
    std::filesystem::path file;
    std::exception_ptr failure;  ///< an Error; null: it is there
  };
  /// The oldest that is not yet told of, if it is done.
  std::optional<Written> take();
  /// The same, after all are done.
  std::optional<Written> waitAndTake();

 private:
  std::deque<std::shared_future<Written>> under_way_;
};

}  // namespace lode::app
