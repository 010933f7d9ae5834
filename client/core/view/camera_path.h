#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "common/codec/model_summary.h"

namespace lode::core {

constexpr uint64_t kMaxCameraPathBytes = 16u << 20;
constexpr size_t kMaxCameraKeys = 100'000;
constexpr double kMinFovDeg = 0.01, kMaxFovDeg = 170;
constexpr uint32_t kMaxPictureSidePx = 32768;

/// A camera at a point in time, in true coordinates.
struct CameraKey {
  double t = 0;  ///< time in seconds
  glm::dvec3 eye{0}, target{0}, up{0, 1, 0};
  bool operator==(const CameraKey&) const = default;
};

/// An animated camera. Its JSON form is {"fov_y_deg": 45, "keys": [{"t": 0, "eye": [x,y,z], "target":
/// [x,y,z], "up": [x,y,z]}]}.
struct CameraPath {
  double fov_y_deg = 45;
  std::vector<CameraKey> keys;  ///< at least one key; t increases strictly
};

/// Parses a camera path. @param source  name that error messages give to the text.
/// @throws Error kInput or kLimit.
CameraPath parseCameraPath(std::string_view json, std::string_view source);

/// Reads a camera path from a file. @throws Error kInput, kLimit or kIo.
CameraPath readCameraPath(const std::filesystem::path& file);

/// Returns the camera at a time. At a key's time, the camera equals the key; before the first key and after
/// the last, the camera does not move. Catmull-Rom splines interpolate eye and target; up is interpolated
/// linearly.
/// Source: Catmull & Rom, A Class of Local Interpolating Splines, 1974 (non-uniform, finite differences).
CameraKey cameraAt(const CameraPath& path, double t);

/// Converts a camera to a view in the model frame: subtracts the lattice origin in double precision.
View toView(const CameraKey& camera, double fov_y_deg, uint32_t width_px, uint32_t height_px,
            const ModelSummary& model);

}  // namespace lode::core
