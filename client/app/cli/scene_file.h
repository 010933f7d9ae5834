#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "client/core/view/view.h"
#include "common/error.h"

namespace lode::app {

constexpr uint64_t kMaxSceneBytes = 4u << 20;
constexpr size_t kMaxSceneModels = 64;
constexpr size_t kMaxSceneInstances = 10'000;
constexpr double kMaxSceneCoordinate = 1e12;
constexpr double kMinSceneScale = 1e-6, kMaxSceneScale = 1e6;

/// Placement of a model in a scene. Maps a point p of the model, in the coordinates of the model's file, to
/// the point position + rotation * (scale * p) of the scene.
struct Placement {
  glm::dvec3 position{0};
  glm::dquat rotation{1, 0, 0, 0};  ///< unit length
  double scale = 1;                 ///< factor for all three axes, > 0
};

struct SceneInstance {
  uint32_t model = 0;  ///< index in Scene::models
  Placement placement;
};

/// A horizontal ground plane.
struct SceneGround {
  double height = 0;  ///< coordinate of the plane along Scene::up
  glm::u8vec3 colour_srgb{96, 100, 88};
};

struct SceneSky {
  glm::u8vec3 top_srgb{77, 87, 99}, bottom_srgb{26, 28, 33};
};

/// A model that instances of the scene show.
struct SceneModel {
  std::string name;  ///< name by which instances refer to the model
  /// TARGET as on the command line. parseScene() leaves a path relative to the scene file's folder;
  /// readScene() resolves the path.
  std::string target;
};

struct Scene {
  glm::dvec3 up{0, 0, 1};  ///< unit length
  std::vector<SceneModel> models;
  std::vector<SceneInstance> instances;  ///< at least one
  std::optional<SceneGround> ground;
  std::optional<SceneSky> sky;
  bool is_single_model = false;  ///< true if sceneOf() made the scene for one model, without a scene file
};

/// Quotes a name from a scene file for a message, as one line of ASCII. Shortens a long name.
std::string quoted(const std::string& name);

/// Parses a scene. Example: {"up": "z", "models": {"rock": "rock.lode"}, "instances": [{"model": "rock",
/// "position": [0,0,0], "axis": [0,0,1], "degrees": 30, "scale": 2}], "ground": {"height": 0, "colour":
/// "#606458"}, "sky": {"top": "#4d5763", "bottom": "#1a1c21"}}.
/// @param source  name of the text for error messages.
/// @throws Error kInput or kLimit; the message names the member and the remedy.
Scene parseScene(std::string_view json, std::string_view source);
/// Reads and parses a scene file. @throws Error as parseScene(), or kIo.
Scene readScene(const std::filesystem::path& file);
/// Reads the scene if the target names a scene file. Otherwise returns a scene of one model at the model's
/// own coordinates; Scene::up of this scene has no meaning. @throws Error as readScene().
Scene sceneOf(const std::string& target);
/// Prefixes an error from opening a model with the names of the scene file and the model. Returns the error
/// unchanged if the scene is a single model.
Error ofSceneModel(const Error& error, std::string_view source, const Scene& scene, size_t model);

/// Transforms a view of the scene into the frame of an instance's model. For a single model, subtracts the
/// origin and adds no other rounding.
/// @param view    view of the scene; its eye and near distance are in scene coordinates.
/// @param origin  origin of the model's lattice, in the coordinates of the model's file.
core::View viewFrom(const core::View& view, const Placement& placement, const glm::dvec3& origin) noexcept;

}  // namespace lode::app
