#include "client/core/view/camera_path.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "client/core/view/strict_json.h"
#include "common/error.h"
#include "common/io/file_io.h"

namespace lode::core {
namespace {

using Json = nlohmann::json;

constexpr double kMaxCoordinate = 1e15;  // limit that keeps squares of coordinates from overflowing

[[noreturn]] void refuse(std::string_view source, const std::string& what) {
  throw Error(
      ErrorCode::kInput,
      std::string(source) + ": " + what +
          R"(; a camera path looks like {"fov_y_deg": 45, "keys": [{"t": 0, "eye": [0,0,5], "target": [0,0,0], )"
          R"("up": [0,1,0]}]})");
}

/// Rejects unknown members. Otherwise a misspelt member would be ignored silently.
void refuseOthers(const Json& object, std::initializer_list<std::string_view> known, std::string_view source,
                  const std::string& where) {
  for (const auto& [name, value] : object.items())
    if (std::ranges::find(known, name) == known.end())
      refuse(source, where + " has no member " + Json(name).dump(-1, ' ', true));
}

double parseNumber(const Json& value, std::string_view source, const std::string& what) {
  if (!value.is_number()) refuse(source, what + " is not a number");
  const double number = value.get<double>();
  if (!std::isfinite(number) || std::abs(number) > kMaxCoordinate)
    refuse(source, what + " must be from -1e15 to 1e15");
  return number;
}

glm::dvec3 parseVector(const Json& key, const char* name, std::string_view source, const std::string& where) {
  const auto value = key.find(name);
  const std::string what = where + "." + name;
  if (value == key.end()) refuse(source, what + " is missing");
  if (!value->is_array() || value->size() != 3) refuse(source, what + " is not a list of three numbers");
  glm::dvec3 vector;
  for (int axis = 0; axis < 3; ++axis)
    vector[axis] = parseNumber((*value)[static_cast<size_t>(axis)], source, what);
  return vector;
}

CameraKey parseKey(const Json& json, std::string_view source, const std::string& where) {
  if (!json.is_object()) refuse(source, where + " is not an object");
  refuseOthers(json, {"t", "eye", "target", "up"}, source, where);
  CameraKey key;
  if (const auto t = json.find("t"); t != json.end()) key.t = parseNumber(*t, source, where + ".t");
  key.eye = parseVector(json, "eye", source, where);
  key.target = parseVector(json, "target", source, where);
  key.up = json.contains("up") ? parseVector(json, "up", source, where) : glm::dvec3(0, 1, 0);
  const double looking = glm::length(key.target - key.eye), up = glm::length(key.up);
  if (!(looking > 0)) refuse(source, where + " looks from the target itself");
  if (!(up > 0)) refuse(source, where + ".up must not be zero");
  if (glm::length(glm::cross((key.target - key.eye) / looking, key.up / up)) < 1e-6)
    refuse(source, where + ".up points along the view");
  return key;
}

/// Returns the tangent of a spline at a key, by finite differences.
template <typename Get>
glm::dvec3 tangent(const std::vector<CameraKey>& keys, size_t at, Get get) {
  const size_t before = at == 0 ? 0 : at - 1, after = std::min(at + 1, keys.size() - 1);
  return (get(keys[after]) - get(keys[before])) / (keys[after].t - keys[before].t);
}

/// Interpolates between keys[at] and keys[at + 1].
template <typename Get>
glm::dvec3 spline(const std::vector<CameraKey>& keys, size_t at, double t, Get get) {
  const double span = keys[at + 1].t - keys[at].t;
  const double s = (t - keys[at].t) / span, s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * get(keys[at]) + (s3 - 2 * s2 + s) * span * tangent(keys, at, get) +
         (3 * s2 - 2 * s3) * get(keys[at + 1]) + (s3 - s2) * span * tangent(keys, at + 1, get);
}

/// Returns the unit vector perpendicular to `forward` whose direction is nearest to `up`. If `up` is parallel
/// to `forward`, uses another axis in its place.
glm::dvec3 upright(const glm::dvec3& forward, const glm::dvec3& up) {
  for (const glm::dvec3& towards : {up, glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
    const glm::dvec3 across = towards - glm::dot(towards, forward) * forward;
    const double length = glm::length(across);
    if (length > 1e-9 * glm::length(towards)) return across / length;
  }
  return {0, 1, 0};
}

}  // namespace

CameraPath parseCameraPath(std::string_view text, std::string_view source) {
  if (text.size() > kMaxCameraPathBytes)
    throw Error(ErrorCode::kLimit, std::string(source) + ": a camera path of " + std::to_string(text.size()) +
                                       " bytes; the limit is " + std::to_string(kMaxCameraPathBytes));
  std::string problem;
  const Json json = parseStrictly<Json>(text, problem);
  if (!problem.empty()) refuse(source, problem);
  if (!json.is_object()) refuse(source, "not a JSON object");
  refuseOthers(json, {"fov_y_deg", "keys"}, source, "a camera path");
  CameraPath path;
  if (const auto fov = json.find("fov_y_deg"); fov != json.end()) {
    path.fov_y_deg = parseNumber(*fov, source, "fov_y_deg");
    if (path.fov_y_deg < kMinFovDeg || path.fov_y_deg > kMaxFovDeg)
      refuse(source, "fov_y_deg must be from 0.01 to 170");
  }
  const auto keys = json.find("keys");
  if (keys == json.end() || !keys->is_array() || keys->empty())
    refuse(source, "keys must be a list with at least one key");
  if (keys->size() > kMaxCameraKeys)
    throw Error(ErrorCode::kLimit, std::string(source) + ": " + std::to_string(keys->size()) +
                                       " keys; the limit is " + std::to_string(kMaxCameraKeys));
  path.keys.reserve(keys->size());
  for (const Json& key : *keys) {
    const std::string where = "keys[" + std::to_string(path.keys.size()) + "]";
    if (keys->size() > 1 && key.is_object() && !key.contains("t")) refuse(source, where + ".t is missing");
    path.keys.push_back(parseKey(key, source, where));
    if (path.keys.size() > 1 && !(path.keys.back().t > path.keys[path.keys.size() - 2].t))
      refuse(source, where + ".t is not after the key before");
  }
  return path;
}

CameraPath readCameraPath(const std::filesystem::path& file) {
  refuseUnlessFile(file, "a camera path, a JSON file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Error(ErrorCode::kIo, file.string() + ": cannot open the camera path; check the name");
  std::string text(kMaxCameraPathBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) throw Error(ErrorCode::kIo, file.string() + ": cannot read the camera path");
  text.resize(static_cast<size_t>(stream.gcount()));
  return parseCameraPath(text, file.string());
}

CameraKey cameraAt(const CameraPath& path, double t) {
  const auto& keys = path.keys;
  const auto after = std::upper_bound(keys.begin(), keys.end(), t,
                                      [](double time, const CameraKey& key) { return time < key.t; });
  if (after == keys.begin()) return keys.front();
  if (after == keys.end() || (after - 1)->t == t) return *(after - 1);
  const size_t at = static_cast<size_t>(after - keys.begin()) - 1;
  CameraKey camera;
  camera.t = t;
  camera.eye = spline(keys, at, t, [](const CameraKey& key) { return key.eye; });
  camera.target = spline(keys, at, t, [](const CameraKey& key) { return key.target; });
  const double s = (t - keys[at].t) / (keys[at + 1].t - keys[at].t);
  camera.up = glm::mix(glm::normalize(keys[at].up), glm::normalize(keys[at + 1].up), s);
  return camera;
}

View toView(const CameraKey& camera, double fov_y_deg, uint32_t width_px, uint32_t height_px,
            const ModelSummary& model) {
  View view;
  view.eye_model = camera.eye - model.lattice.origin;
  const glm::dvec3 looking = camera.target - camera.eye;
  const double length = glm::length(looking);
  view.forward = length > 0 ? looking / length : glm::dvec3(0, 0, -1);
  view.up = upright(view.forward, camera.up);
  view.fov_y_rad = glm::radians(fov_y_deg);
  view.width_px = width_px;
  view.height_px = height_px;
  view.near_model = model.lattice.step;
  return view;
}

}  // namespace lode::core
