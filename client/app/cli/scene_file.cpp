#include "client/app/cli/scene_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>

#include <nlohmann/json.hpp>

#include "client/app/cli/target.h"
#include "client/core/view/strict_json.h"
#include "common/error.h"
#include "common/io/file_io.h"

namespace lode::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMostQuotedBytes = 64;  ///< largest number of bytes of a name that are quoted

[[noreturn]] void refuseScene(std::string_view source, const std::string& what) {
  throw Error(ErrorCode::kInput,
              std::string(source) + ": " + what +
                  R"(; a scene looks like {"models": {"rock": "rock.lode"}, "instances": [{"model": "rock", )"
                  R"("position": [0,0,0]}]})");
}

void refuseMoreThan(size_t limit, size_t count, const char* what, std::string_view source) {
  if (count <= limit) return;
  throw Error(ErrorCode::kLimit, std::string(source) + ": " + std::to_string(count) + " " + what +
                                     "; the limit is " + std::to_string(limit));
}

/// Rejects unknown members, because a misspelt member would otherwise be ignored silently.
void refuseOthers(const Json& object, std::initializer_list<std::string_view> known, std::string_view source,
                  const std::string& where) {
  if (!object.is_object()) refuseScene(source, where + " is not an object");
  for (const auto& [name, value] : object.items())
    if (std::ranges::find(known, name) == known.end())
      refuseScene(source, where + " has no member " + quoted(name));
}

double numberOf(const Json& value, double least, double largest, std::string_view source,
                const std::string& what) {
  if (!value.is_number()) refuseScene(source, what + " is not a number");
  const double number = value.get<double>();
  if (!(number >= least && number <= largest)) {
    char range[64];
    std::snprintf(range, sizeof range, " must be from %g to %g", least, largest);
    refuseScene(source, what + range);
  }
  return number;
}

glm::dvec3 vectorOf(const Json& value, std::string_view source, const std::string& what) {
  if (!value.is_array() || value.size() != 3) refuseScene(source, what + " is not a list of three numbers");
  glm::dvec3 vector;
  for (int axis = 0; axis < 3; ++axis)
    vector[axis] =
        numberOf(value[static_cast<size_t>(axis)], -kMaxSceneCoordinate, kMaxSceneCoordinate, source, what);
  return vector;
}

const std::string& textOf(const Json& value, std::string_view source, const std::string& what) {
  if (!value.is_string()) refuseScene(source, what + " is not a text");
  return value.get_ref<const std::string&>();
}

glm::u8vec3 colourOf(const Json& value, std::string_view source, const std::string& what) {
  const std::string& text = textOf(value, source, what);
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (text.size() != 7 || text[0] != '#' || !std::all_of(text.begin() + 1, text.end(), is_digit))
    refuseScene(source, what + " is not a colour like #4d5763");
  const auto packed = std::stoul(text.substr(1), nullptr, 16);
  return glm::u8vec3(packed >> 16, packed >> 8 & 255, packed & 255);
}

glm::dvec3 upOf(const Json& value, std::string_view source) {
  static const std::map<std::string, glm::dvec3> kAxes{{"x", {1, 0, 0}},   {"y", {0, 1, 0}},
                                                       {"z", {0, 0, 1}},   {"-x", {-1, 0, 0}},
                                                       {"-y", {0, -1, 0}}, {"-z", {0, 0, -1}}};
  const auto axis = kAxes.find(textOf(value, source, "up"));
  if (axis == kAxes.end()) refuseScene(source, "up is none of x, y, z, -x, -y, -z");
  return axis->second;
}

Placement placementOf(const Json& json, std::string_view source, const std::string& where) {
  Placement placement;
  if (const auto at = json.find("position"); at != json.end())
    placement.position = vectorOf(*at, source, where + ".position");
  if (const auto scale = json.find("scale"); scale != json.end())
    placement.scale = numberOf(*scale, kMinSceneScale, kMaxSceneScale, source, where + ".scale");
  const auto axis = json.find("axis"), degrees = json.find("degrees");
  if ((axis == json.end()) != (degrees == json.end()))
    refuseScene(source, where + " needs both axis and degrees, or neither");
  if (axis == json.end()) return placement;
  const glm::dvec3 about = vectorOf(*axis, source, where + ".axis");
  const double turn = numberOf(*degrees, -1e6, 1e6, source, where + ".degrees");
  if (!(glm::length(about) > 0)) refuseScene(source, where + ".axis must not be zero");
  placement.rotation = glm::angleAxis(std::fmod(turn, 360.0) * std::numbers::pi / 180, glm::normalize(about));
  return placement;
}

/// Adds the models of the JSON to the scene. @return for each model's name, its index in Scene::models.
std::map<std::string, uint32_t> addModels(const Json& json, std::string_view source, Scene& scene) {
  const auto models = json.find("models");
  if (models == json.end() || !models->is_object() || models->empty())
    refuseScene(source, "models must be an object with at least one model");
  refuseMoreThan(kMaxSceneModels, models->size(), "models", source);
  std::map<std::string, uint32_t> numbers;
  for (const auto& [name, target] : models->items()) {
    numbers.emplace(name, static_cast<uint32_t>(scene.models.size()));
    scene.models.push_back({name, textOf(target, source, "models." + quoted(name))});
    const SceneModel& model = scene.models.back();
    if (model.target.empty()) refuseScene(source, "models." + quoted(name) + " is empty");
    if (namesScene(model.target))
      refuseScene(source, "models." + quoted(name) + " is itself a scene: name a store, a PLY or an address");
  }
  return numbers;
}

void addInstances(const Json& json, const std::map<std::string, uint32_t>& models, std::string_view source,
                  Scene& scene) {
  const auto instances = json.find("instances");
  if (instances == json.end() || !instances->is_array() || instances->empty())
    refuseScene(source, "instances must be a list with at least one instance");
  refuseMoreThan(kMaxSceneInstances, instances->size(), "instances", source);
  scene.instances.reserve(instances->size());
  for (const Json& instance : *instances) {
    const std::string where = "instances[" + std::to_string(scene.instances.size()) + "]";
    refuseOthers(instance, {"model", "position", "axis", "degrees", "scale"}, source, where);
    const auto name = instance.find("model");
    if (name == instance.end()) refuseScene(source, where + ".model is missing");
    const auto model = models.find(textOf(*name, source, where + ".model"));
    if (model == models.end()) refuseScene(source, where + ".model is not a name in models");
    scene.instances.push_back({model->second, placementOf(instance, source, where)});
  }
}

}  // namespace

std::string quoted(const std::string& name) {
  // A UTF-8 character that is cut in two here is dropped by dump().
  std::string text = name.substr(0, kMostQuotedBytes);
  text = Json(text).dump(-1, ' ', true, Json::error_handler_t::ignore);
  if (name.size() > kMostQuotedBytes) text.insert(text.size() - 1, "...");
  return text;
}

Scene parseScene(std::string_view text, std::string_view source) {
  refuseMoreThan(kMaxSceneBytes, text.size(), "bytes", source);
  std::string problem;
  const Json json = core::parseStrictly<Json>(text, problem);
  if (!problem.empty()) refuseScene(source, problem);
  refuseOthers(json, {"up", "models", "instances", "ground", "sky"}, source, "the scene");
  Scene scene;
  if (const auto up = json.find("up"); up != json.end()) scene.up = upOf(*up, source);
  addInstances(json, addModels(json, source, scene), source, scene);
  if (const auto ground = json.find("ground"); ground != json.end()) {
    refuseOthers(*ground, {"height", "colour"}, source, "ground");
    scene.ground.emplace();
    if (const auto height = ground->find("height"); height != ground->end())
      scene.ground->height =
          numberOf(*height, -kMaxSceneCoordinate, kMaxSceneCoordinate, source, "ground.height");
    if (const auto colour = ground->find("colour"); colour != ground->end())
      scene.ground->colour_srgb = colourOf(*colour, source, "ground.colour");
  }
  if (const auto sky = json.find("sky"); sky != json.end()) {
    refuseOthers(*sky, {"top", "bottom"}, source, "sky");
    scene.sky.emplace();
    if (const auto top = sky->find("top"); top != sky->end())
      scene.sky->top_srgb = colourOf(*top, source, "sky.top");
    if (const auto bottom = sky->find("bottom"); bottom != sky->end())
      scene.sky->bottom_srgb = colourOf(*bottom, source, "sky.bottom");
  }
  return scene;
}

Scene readScene(const std::filesystem::path& file) {
  refuseUnlessFile(file, "a scene, a JSON file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Error(ErrorCode::kIo, file.string() + ": cannot open the scene; check the name");
  std::string text(kMaxSceneBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) throw Error(ErrorCode::kIo, file.string() + ": cannot read the scene");
  text.resize(static_cast<size_t>(stream.gcount()));
  Scene scene = parseScene(text, file.string());
  for (SceneModel& model : scene.models)
    if (model.target.find("://") == std::string::npos)
      model.target = (file.parent_path() / model.target).lexically_normal().string();
  return scene;
}

Scene sceneOf(const std::string& target) {
  if (namesScene(target)) return readScene(target);
  Scene scene;
  scene.models.push_back({target, target});
  scene.instances.emplace_back();
  scene.is_single_model = true;
  return scene;
}

Error ofSceneModel(const Error& error, std::string_view source, const Scene& scene, size_t model) {
  if (scene.is_single_model) return error;
  return Error(error.code(),
               std::string(source) + ": models." + quoted(scene.models[model].name) + ": " + error.what(),
               error.remedy());
}

core::View viewFrom(const core::View& view, const Placement& placement, const glm::dvec3& origin) noexcept {
  const glm::dquat back = glm::conjugate(placement.rotation);
  const glm::dvec3 origin_in_scene = placement.position + placement.rotation * (placement.scale * origin);
  core::View seen = view;
  seen.eye_model = back * (view.eye_model - origin_in_scene) / placement.scale;
  seen.forward = back * view.forward;
  seen.up = back * view.up;
  seen.near_model = view.near_model / placement.scale;
  return seen;
}

}  // namespace lode::app
