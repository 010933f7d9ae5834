#include "client/app/window/output/picture_writer.h"

#include <chrono>
#include <memory>
#include <system_error>
#include <utility>

#include "common/error.h"

namespace lode::app {
namespace {

constexpr size_t kMaxQueued = 8;

std::exception_ptr tryToWrite(const std::filesystem::path& file, const render::Image& image) {
  try {
    render::writePng(file, image, OutputName::kDerived);
    return nullptr;
  } catch (const Error&) {
    return std::current_exception();
  } catch (const std::exception& error) {
    return std::make_exception_ptr(Error(ErrorCode::kInternal, file.string() + ": " + error.what()));
  }
}

}  // namespace

void PictureWriter::write(std::filesystem::path file, render::Image image) {
  if (queued_.size() >= kMaxQueued) queued_.front().wait();
  std::shared_future<Written> before;
  if (!queued_.empty()) before = queued_.back();
  auto shared = std::make_shared<const render::Image>(std::move(image));
  // The task owns the image and the previous future, so that both are freed as soon as the picture is
  // written, even if take() is called much later.
  auto write = [file = std::move(file), shared = std::move(shared), before = std::move(before)]() mutable {
    if (before.valid()) before.wait();
    before = {};
    std::exception_ptr failure = tryToWrite(file, *shared);
    shared.reset();
    return Written{std::move(file), std::move(failure)};
  };
  try {
    queued_.push_back(std::async(std::launch::async, write).share());
  } catch (const std::system_error&) {
    std::promise<Written> done;
    done.set_value(write());
    queued_.push_back(done.get_future().share());
  }
}

std::optional<PictureWriter::Written> PictureWriter::take() {
  using namespace std::chrono_literals;
  if (queued_.empty() || queued_.front().wait_for(0s) != std::future_status::ready) return std::nullopt;
  const Written written = queued_.front().get();
  queued_.pop_front();
  return written;
}

std::optional<PictureWriter::Written> PictureWriter::waitAndTake() {
  if (!queued_.empty()) queued_.back().wait();
  return take();
}

}  // namespace lode::app
