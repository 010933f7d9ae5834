#include "client/app/window/camera/pilot.h"

#include <cstdio>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "client/app/cli/made_path.h"
#include "client/app/window/pacing.h"
#include "common/error.h"

namespace lode::app {
namespace {

[[noreturn]] void refuse(const std::string& target, const stream::StreamStatus& status) {
  const std::string& why = status.failure.empty() ? status.trouble : status.failure;
  throw Error(ErrorCode::kTimeout, target + " gave no first picture to fly from" +
                                       (why.empty() ? "; allow more with --timeout" : ": " + why));
}

}  // namespace

Pilot::Pilot(const ViewOptions& options, std::optional<core::CameraPath> path)
    : options_(options), path_(std::move(path)) {}

/// There is a picture to begin with.
bool Pilot::mayBegin(const ViewedScene& scene, bool is_time_over, const core::View& view) const {
  const double drawn_px = scene.drawnThresholdRad() * focalPx(view);
  if (drawn_px > 0 && drawn_px <= kLargestThresholdPx) return true;
  const stream::StreamStatus& status = scene.status();
  const bool is_all_there = (status.ended || status.exhausted) && scene.uploaded();
  if (is_all_there || is_time_over) refuse(options_.common.target, status);
  return false;
}

Pilot::State Pilot::fly(const ViewedScene& scene, bool is_time_over, CameraRig& rig) {
  if (!flight_) {
    if (!mayBegin(scene, is_time_over, rig.view())) return State::kWaiting;
    flight_.emplace(path_ ? *path_ : makePath(MadePath::kOrbit, scene.summary(), 0), options_.laps);
    start_ = Clock::now();
  }
  const std::chrono::duration<double> flown = Clock::now() - start_;
  const std::optional<core::CameraKey> camera = flight_->cameraAt(flown.count());
  if (!camera) return State::kOver;
  rig.lookFrom(*camera, flight_->fovYDeg());
  return State::kFlying;
}

void Pilot::draw(uint64_t number, const FlownFrame& frame) {
  if (flight_) flight_->draw(number, frame);
}

void Pilot::finish(uint64_t number, double work_ms) {
  if (flight_) flight_->finish(number, work_ms);
}

void Pilot::tell() const {
  const std::string closed = options_.common.target + ": the window was closed before the flight ";
  if (!flight_) throw Error(ErrorCode::kTimeout, closed + "began");
  const std::string said = options_.json ? flight_->toJson().dump() + "\n" : flight_->describe();
  std::fputs(said.c_str(), stdout);
  if (!flight_->isOver()) throw Error(ErrorCode::kTimeout, closed + "was over: what was flown is told");
}

}  // namespace lode::app
