#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include <glm/glm.hpp>

#include "client/core/view/time_point.h"
#include "client/loadtest/request_trace.h"
#include "client/net/address.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Seconds as steps of the clock.
inline core::TimePoint::duration ofSeconds(double count) {
  return std::chrono::duration_cast<core::TimePoint::duration>(std::chrono::duration<double>(count));
}

/// What the clients of one model in a load test are told.
struct LoadPlan {
  stream::ServedModel model;
  stream::StreamOptions options;
  net::Route route;    ///< to the model's server
  RequestTrace trace;  ///< for clients that replay one
  /// For full clients, each with a seed of its own.
  std::function<core::CameraPath(const ModelSummary&, uint64_t seed)> path_of;
  glm::uvec2 size_px{1280, 720};
  float pixels = 1;
  double fps = 10;
  double think_s = 0;  ///< pause at the end of each round, in the mean
  bool decode = true;
  core::TimePoint end{};
};

/// How long a client pauses at the end of a round: at any moment it is as likely as at any other to go on.
inline double somePause(double mean_s, std::mt19937_64& random) {
  return -mean_s * std::log1p(-static_cast<double>(random() >> 11) * 0x1p-53);
}

}  // namespace lode::app
