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

/// A camera at one time, in true coordinates.
struct CameraKey {
  double t = 0;  ///< seconds
  glm::dvec3 eye{0}, target{0}, up{0, 1, 0};
  bool operator==(const CameraKey&) const = default;
};

/// A moving camera: {"fov_y_deg": 45, "keys": [{"t": 0, "eye": [x,y,z], "target": [x,y,z], "up": [x,y,z]}]}.
struct CameraPath {
  double fov_y_deg = 45;
  std::vector<CameraKey> keys;  ///< at least one; t increases
};

/// @param source  names the text in errors.
/// @throws Error kInput or kLimit, naming the key and the remedy.
CameraPath parseCameraPath(std::string_view json, std::string_view source);

/// @throws Error kIo too.
CameraPath readCameraPath(const std::filesystem::path& file);

/// The camera at a time; before the first key and after the last it stands still. At a key's t it is the key.
/// Eye and target move by Catmull-Rom splines in t, up is interpolated linearly.
/// Source: Catmull & Rom, A Class of Local Interpolating Splines, 1974 (non-uniform, finite differences).
CameraKey cameraAt(const CameraPath& path, double t);

/// The view of a camera in a model's frame: the lattice's origin is subtracted in double.
View toView(const CameraKey& camera, double fov_y_deg, uint32_t width_px, uint32_t height_px,
            const ModelSummary& model);

}  // namespace lode::core
