#include "client/app/window/picture_writer.h"

#include <chrono>
#include <memory>
#include <system_error>
#include <utility>

namespace lode::app {

void PictureWriter::write(std::filesystem::path file, render::Image image) {
  std::shared_future<Written> before;
  if (!under_way_.empty()) before = under_way_.back();
  const auto shared = std::make_shared<const render::Image>(std::move(image));
  const auto write = [file = std::move(file), shared, before] {
    if (before.valid()) before.wait();
    try {
      render::writePng(file, *shared);
      return Written{file, nullptr};
    } catch (...) {
      return Written{file, std::current_exception()};
    }
  };
  try {
    under_way_.push_back(std::async(std::launch::async, write).share());
  } catch (const std::system_error&) {
    std::promise<Written> done;
    done.set_value(write());
    under_way_.push_back(done.get_future().share());
  }
}

std::optional<PictureWriter::Written> PictureWriter::take() {
  using namespace std::chrono_literals;
  if (under_way_.empty() || under_way_.front().wait_for(0s) != std::future_status::ready) return std::nullopt;
  const Written written = under_way_.front().get();
  under_way_.pop_front();
  return written;
}

std::optional<PictureWriter::Written> PictureWriter::waitAndTake() {
  if (!under_way_.empty()) under_way_.back().wait();
  return take();
}

}  // namespace lode::app
