#include "client/app/window/flight.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "client/app/cli/made_path.h"
#include "client/app/window/pacing.h"
#include "common/error.h"

namespace lode::app {
namespace {

/// Percentiles of a lap's values, by the nearest-rank method.
struct Spread {
  double p50 = 0, p99 = 0, max = 0;

  explicit Spread(std::vector<double> values) {
    if (values.empty()) return;
    std::ranges::sort(values);
    const auto at = [&](double part) {
      const auto rank = static_cast<size_t>(std::ceil(part * static_cast<double>(values.size())));
      return values[std::max<size_t>(rank, 1) - 1];
    };
    p50 = at(0.5);
    p99 = at(0.99);
    max = values.back();
  }
  nlohmann::ordered_json toJson() const { return {{"p50", p50}, {"p99", p99}, {"max", max}}; }
};

struct Lap {
  std::vector<const FlownFrame*> frames;

  template <typename Value>
  Spread spreadOf(Value FlownFrame::*value) const {
    std::vector<double> values;
    for (const FlownFrame* const frame : frames) values.push_back(static_cast<double>(frame->*value));
    return Spread(std::move(values));
  }
};

std::vector<Lap> lapsOf(const std::vector<FlownFrame>& frames) {
  std::vector<Lap> laps;
  for (const FlownFrame& frame : frames) {
    laps.resize(std::max<size_t>(laps.size(), static_cast<size_t>(frame.lap) + 1));
    laps[static_cast<size_t>(frame.lap)].frames.push_back(&frame);
  }
  return laps;
}

[[noreturn]] void refuse(const std::string& target, const stream::StreamStatus& status) {
  const bool has_failed = !status.failure.empty();
  const std::string& why = has_failed ? status.failure : status.trouble;
  throw Error(ErrorCode::kTimeout,
              target + " gave no first picture to start the flight from" +
                  (why.empty() ? "; allow more with --timeout" : ": " + why),
              has_failed ? status.failure_remedy : status.trouble_remedy);
}

}  // namespace

Flight::Flight(core::CameraPath path, int laps) : path_(std::move(path)), laps_(laps) {}

std::optional<core::CameraKey> Flight::cameraAt(double seconds) {
  const double first = path_.keys.front().t, length = std::max(path_.keys.back().t - first, 1e-3);
  lap_ = static_cast<int>(seconds / length);
  if (isOver()) return std::nullopt;
  t_s_ = first + seconds - lap_ * length;
  return core::cameraAt(path_, t_s_);
}

void Flight::draw(uint64_t number, FlownFrame frame) {
  if (isOver()) return;
  frame.lap = lap_;
  frame.t_s = t_s_;
  pending_.push_back({number, frame});
}

void Flight::finish(uint64_t number, double work_ms) {
  const auto drawn = std::ranges::find(pending_, number, &Pending::number);
  if (drawn == pending_.end()) return;
  drawn->frame.work_ms = work_ms;
  frames_.push_back(drawn->frame);
  pending_.erase(drawn);
}

std::string Flight::describe() const {
  std::string lines;
  const std::vector<Lap> laps = lapsOf(frames_);
  for (size_t i = 0; i < laps.size(); ++i) {
    const Spread work = laps[i].spreadOf(&FlownFrame::work_ms);
    const Spread upload = laps[i].spreadOf(&FlownFrame::upload_ms);
    const Spread threshold = laps[i].spreadOf(&FlownFrame::threshold_px);
    const Spread target = laps[i].spreadOf(&FlownFrame::target_ms);
    char text[400];
    std::snprintf(text, sizeof text,
                  "lap %zu: %zu frames; frame time %.1f ms median, %.1f ms 99th percentile, %.1f ms maximum; "
                  "upload %.2f, %.2f, %.2f ms; threshold %.2f px median, %.2f px maximum",
                  i + 1, laps[i].frames.size(), work.p50, work.p99, work.max, upload.p50, upload.p99,
                  upload.max, threshold.p50, threshold.max);
    lines += text;
    if (target.p50 > 0) {
      std::snprintf(text, sizeof text, "; target frame time %.1f ms median", target.p50);
      lines += text;
    }
    lines += '\n';
  }
  return lines;
}

nlohmann::ordered_json Flight::toJson() const {
  nlohmann::ordered_json json{{"interrupted", !isOver()},
                              {"laps", nlohmann::ordered_json::array()},
                              {"frames", nlohmann::ordered_json::array()}};
  for (const Lap& lap : lapsOf(frames_))
    json["laps"].push_back({{"frames", lap.frames.size()},
                            {"work_ms", lap.spreadOf(&FlownFrame::work_ms).toJson()},
                            {"upload_ms", lap.spreadOf(&FlownFrame::upload_ms).toJson()},
                            {"target_ms", lap.spreadOf(&FlownFrame::target_ms).toJson()},
                            {"scale", lap.spreadOf(&FlownFrame::scale).toJson()},
                            {"threshold_px", lap.spreadOf(&FlownFrame::threshold_px).toJson()},
                            {"triangles", lap.spreadOf(&FlownFrame::triangles).toJson()}});
  for (const FlownFrame& frame : frames_)
    json["frames"].push_back({{"lap", frame.lap},
                              {"t", frame.t_s},
                              {"work_ms", frame.work_ms},
                              {"upload_ms", frame.upload_ms},
                              {"target_ms", frame.target_ms},
                              {"scale", frame.scale},
                              {"threshold_px", frame.threshold_px},
                              {"triangles", frame.triangles}});
  return json;
}

Pilot::Pilot(const ViewOptions& options, std::optional<core::CameraPath> path)
    : options_(options), path_(std::move(path)) {}

/// Returns true once the window shows a picture that is fine enough to start the flight. @throws Error if no
/// such picture can follow.
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

void Pilot::print() const {
  const std::string closed = options_.common.target + ": the window was closed before the flight ";
  if (!flight_) throw Error(ErrorCode::kTimeout, closed + "began");
  const std::string said = options_.json ? flight_->toJson().dump() + "\n" : flight_->describe();
  std::fputs(said.c_str(), stdout);
  if (!flight_->isOver())
    throw Error(ErrorCode::kTimeout, closed + "was over; the times above cover only the flown part");
}

}  // namespace lode::app
