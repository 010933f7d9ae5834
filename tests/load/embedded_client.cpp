// A program that embeds the library, for hostile_test.py: views a model for some seconds from a camera that
// moves.
//
//   embedded_client URL SECONDS MEMORY_BUDGET_BYTES

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "client/embed/lodestream.h"

namespace {

using Clock = std::chrono::steady_clock;

/// Returns a view of the model's box from a direction that turns with the step.
lodestream::View viewOf(const lodestream::Model& model, int step) {
  lodestream::View view{};
  double radius = 0;
  for (int axis = 0; axis < 3; ++axis) {
    view.target[axis] = (model.box_min[axis] + model.box_max[axis]) / 2;
    radius += std::pow((model.box_max[axis] - model.box_min[axis]) / 2, 2);
  }
  radius = std::sqrt(radius);
  view.eye[0] = view.target[0] + 1.5 * radius * std::cos(0.1 * step);
  view.eye[1] = view.target[1];
  view.eye[2] = view.target[2] + 1.5 * radius * std::sin(0.1 * step);
  view.up[1] = 1;
  view.fov_y_deg = 45;
  view.width_px = 1280;
  view.height_px = 720;
  view.threshold_px = 0.5f;
  return view;
}

/// Returns true if a cut within the threshold has been shown.
bool look(const std::string& url, double seconds, const lodestream::Options& options) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  lodestream::Stream stream(url, options);
  bool is_converged = false;
  for (int step = 0; Clock::now() < end; ++step) {
    const lodestream::Status status = stream.step(20);
    is_converged |= status.is_converged != 0;
    if (status.has_failed != 0) throw lodestream::Error(lodestream_last_error());
    if (status.is_open != 0) stream.setView(viewOf(stream.describe(), step / 10));
  }
  return is_converged;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) {
    std::fprintf(stderr, "usage: embedded_client URL SECONDS MEMORY_BUDGET_BYTES\n");
    return 2;
  }
  try {
    lodestream::Options options{};
    options.memory_budget_bytes = std::strtoull(arguments[3], nullptr, 10);
    if (look(arguments[1], std::strtod(arguments[2], nullptr), options)) return EXIT_SUCCESS;
    std::fprintf(stderr, "embedded_client: nothing has converged in time\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "embedded_client: %s\n", error.what());
  }
  return EXIT_FAILURE;
}
