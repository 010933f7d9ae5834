#include "client/app/window/path_recorder.h"

#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "client/app/window/output/picture_file.h"
#include "common/io/atomic_file.h"

namespace lode::app {

std::string writeCameraPath(const core::CameraPath& path) {
  const auto vector = [](const glm::dvec3& v) { return nlohmann::json::array({v.x, v.y, v.z}); };
  nlohmann::json json{{"fov_y_deg", path.fov_y_deg}, {"keys", nlohmann::json::array()}};
  for (const core::CameraKey& key : path.keys)
    json["keys"].push_back(
        {{"t", key.t}, {"eye", vector(key.eye)}, {"target", vector(key.target)}, {"up", vector(key.up)}});
  return json.dump() + "\n";
}

void PathRecorder::add(double t_s, core::CameraKey camera, double fov_y_deg) {
  constexpr double kKeySeconds = 0.1;
  if (!path_) return;
  auto& keys = path_->keys;
  if (keys.empty()) {
    start_s_ = t_s;
    path_->fov_y_deg = fov_y_deg;
  }
  const bool is_due = keys.empty() || t_s - start_s_ >= keys.back().t + kKeySeconds;
  if (!is_due || keys.size() == core::kMaxCameraKeys) return;
  camera.t = t_s - start_s_;
  keys.push_back(camera);
}

std::optional<core::CameraPath> PathRecorder::finish() {
  std::optional<core::CameraPath> path = std::exchange(path_, std::nullopt);
  if (path && path->keys.empty()) path.reset();
  return path;
}

std::optional<std::string> PathRecorder::save() {
  const std::optional<core::CameraPath> path = finish();
  if (!path) return std::nullopt;
  const std::string file = timedName("json");
  const std::string text = writeCameraPath(*path);
  AtomicFile output(file, {}, OutputName::kDerived);
  output.write(std::as_bytes(std::span(text)));
  output.commit();
  return file;
}

}  // namespace lode::app
