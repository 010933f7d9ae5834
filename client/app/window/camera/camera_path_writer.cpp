#include "client/app/window/camera/camera_path_writer.h"

#include <nlohmann/json.hpp>

namespace lode::core {

std::string writeCameraPath(const CameraPath& path) {
  const auto vector = [](const glm::dvec3& v) { return nlohmann::json::array({v.x, v.y, v.z}); };
  nlohmann::json json{{"fov_y_deg", path.fov_y_deg}, {"keys", nlohmann::json::array()}};
  for (const CameraKey& key : path.keys)
    json["keys"].push_back(
        {{"t", key.t}, {"eye", vector(key.eye)}, {"target", vector(key.target)}, {"up", vector(key.up)}});
  return json.dump() + "\n";
}

}  // namespace lode::core
