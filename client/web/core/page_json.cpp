#include "client/web/core/page_json.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/render/gl/eye.h"
#include "client/render/passes/light.h"
#include "common/error.h"
#include "common/image/image.h"
#include "common/up_axis.h"

namespace lode::web {
namespace {

using Json = nlohmann::json;

constexpr uint32_t kMaxSidePx = 16'384;

/// Calls a function that reads JSON, and turns the library's exceptions into an Error.
template <typename Read>
auto reading(std::string_view text, const Read& read) {
  try {
    return read(Json::parse(text));
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kInput, std::string("the page passed wrong JSON: ") + error.what());
  }
}

glm::dvec3 vectorOf(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

glm::dvec2 placeOf(const Json& json, const char* name) {
  const auto found = json.find(name);
  if (found == json.end() || found->is_null()) return {0, 0};
  return {found->at(0).get<double>(), found->at(1).get<double>()};
}

bool has(const Json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && !found->is_null();
}

float thresholdOf(const Json& json) { return std::clamp(json.value("threshold_px", 1.0f), 0.1f, 1000.0f); }

uint32_t sideOf(const Json& json, const char* name) {
  return static_cast<uint32_t>(std::clamp(json.value(name, 1.0), 1.0, double{kMaxSidePx}));
}

Json toJson(const glm::dvec3& vector) { return {vector.x, vector.y, vector.z}; }

std::string_view nameOf(app::CameraKind kind) noexcept {
  if (kind == app::CameraKind::kOrbit) return "orbit";
  return kind == app::CameraKind::kFly ? "fly" : "walk";
}

std::string hexOf(const glm::u8vec3& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", colour.r, colour.g, colour.b);
  return text;
}

app::Input inputOf(const Json& json) {
  app::Input input;
  input.turned_px = placeOf(json, "turned_px");
  input.shifted_px = placeOf(json, "shifted_px");
  input.wheel = json.value("wheel", 0.0);
  input.pointer_px = placeOf(json, "pointer_px");
  input.pressed = has(json, "pressed_px");
  input.pressed_px = placeOf(json, "pressed_px");
  if (has(json, "double_click_px")) {
    input.double_clicked = true;
    input.pressed = false;
    input.pointer_px = placeOf(json, "double_click_px");
  }
  if (const auto fly = json.find("fly"); fly != json.end() && fly->is_object()) {
    input.fly.right = fly->value("right", 0.0);
    input.fly.up = fly->value("up", 0.0);
    input.fly.forward = fly->value("forward", 0.0);
    input.fly.fast = fly->value("fast", false);
  }
  input.reset_camera = json.value("reset", false);
  input.next_camera = std::clamp(json.value("next_camera", 0), 0, app::kCameraKindCount);
  input.next_axis = std::clamp(json.value("next_axis", 0), 0, 6);
  input.toggle_parallel = json.value("parallel", false);
  if (has(json, "side")) {
    const auto name = json.at("side").get<std::string>();
    const auto* const side = std::ranges::find(core::kSideNames, name);
    if (side != core::kSideNames.end()) input.side = static_cast<core::Side>(side - core::kSideNames.begin());
  }
  return input;
}

Json uniformsOf(const WebModel& model, const FrameInput& /*frame*/) {
  const core::View& view = model.rig().view();
  const double step = model.cut() ? model.cut()->lattice_step : 1;
  const render::SplitEye eye = render::splitEye(view.eye_model, step);
  const glm::mat3 rotation = render::viewRotation(view);
  const render::Projection projection = render::reversedProjection(view, step);
  const render::Light light = render::lightFor(view, model.rig().up());
  Json columns = Json::array();
  for (int i = 0; i < 9; ++i) columns.push_back(rotation[i / 3][i % 3]);
  Json uniforms{{"eye_high", {eye.high.x, eye.high.y, eye.high.z}},
                {"eye_low", toJson(eye.low)},
                {"lattice_step", step},
                {"view_rotation", std::move(columns)},
                {"projection", {projection.scale.x, projection.scale.y, model.nearModel()}},
                {"to_sun", toJson(light.to_sun)},
                {"up", toJson(light.up)},
                {"exposure", 1},
                {"uv_frame", {0, 0, 0}},
                {"texture_count", 0}};
  if (model.cut() && model.cut()->textures) {
    const TextureSet& set = *model.cut()->textures;
    // Keep only the fraction of the origin, because textures repeat and floats near zero are more precise.
    const glm::dvec2 origin = set.uv_origin - glm::floor(set.uv_origin);
    uniforms["uv_frame"] = {origin.x, origin.y, uvStep(set)};
    uniforms["texture_count"] = set.textures.size();
  }
  Json colours = Json::array();
  for (const glm::u8vec3& colour : render::texelColours())
    for (int i = 0; i < 3; ++i) colours.push_back(linearOf(colour[i]));
  uniforms["texel_colours"] = std::move(colours);
  return uniforms;
}

Json statusOf(WebModel& model, const FrameInput& frame) {
  const core::Engine& engine = model.engine();
  const core::EngineCounts counts = engine.counts();
  const std::shared_ptr<const core::Cut>& cut = model.cut();
  uint64_t triangles = 0;
  for (const DrawnPart& part : model.parts()) triangles += model.mesh(part.id)->triangles.size();
  return {{"triangles", cut ? cut->triangles : 0},
          {"drawn_triangles", triangles},
          {"error_px", model.shownErrorPx()},
          {"cut_error_px", cut ? cut->max_error_px : 0},
          {"threshold_px", frame.threshold_px},
          {"converged", cut && cut->converged && cut->view == model.rig().view()},
          {"settled", engine.settled()},
          {"limited", engine.limited()},
          {"received_bytes", counts.received_bytes},
          {"cache_bytes", counts.cache_bytes},
          {"resident_bytes", counts.resident_bytes},
          {"texture_bytes", counts.texture_bytes},
          {"open_requests", counts.open_requests},
          {"decoding", counts.decoding},
          {"link_bytes_per_s", counts.link_bytes_per_s},
          {"round_trip_ms", counts.round_trip_ms},
          {"trouble", engine.trouble()},
          {"failure", engine.failure()},
          {"tiles_left_out", counts.tiles_left_out},
          {"lost_tiles", cut ? cut->lost_tiles : 0},
          {"build", engine.cutBuild()}};
}

}  // namespace

WebModelOptions parseOptions(std::string_view text) {
  return reading(text, [](const Json& json) {
    WebModelOptions options;
    options.model = json.at("model").get<std::string>();
    options.token = json.value("token", "");
    options.memory_bytes = static_cast<uint64_t>(std::clamp(json.value("memory_bytes", 1e9), 32e6, 3e9));
    options.seed = static_cast<uint32_t>(json.value("seed", 0.0));
    options.has_cache = json.value("has_cache", false);
    return options;
  });
}

CameraStart parseCameraStart(std::string_view text) {
  return reading(text, [](const Json& json) {
    CameraStart start;
    start.width_px = sideOf(json, "width_px");
    start.height_px = sideOf(json, "height_px");
    start.threshold_px = thresholdOf(json);
    if (has(json, "up")) start.up = parseAxis(json.at("up").get<std::string>());
    if (!has(json, "camera")) return start;
    const Json& camera = json.at("camera");
    const Json path{
        {"fov_y_deg", camera.value("fov_y_deg", 45.0)},
        {"keys", {{{"eye", camera.at("eye")}, {"target", camera.at("target")}, {"up", camera.at("up")}}}}};
    start.path = core::parseCameraPath(path.dump(), "the link");
    return start;
  });
}

FrameInput parseFrame(std::string_view text) {
  return reading(text, [](const Json& json) {
    FrameInput frame;
    frame.width_px = sideOf(json, "width_px");
    frame.height_px = sideOf(json, "height_px");
    frame.threshold_px = thresholdOf(json);
    frame.seconds = std::clamp(json.value("seconds", 0.0), 0.0, 0.25);
    frame.show = render::colorModeNamed(json.value("show", "surface")).value_or(render::ColorMode::kSurface);
    frame.input = inputOf(json);
    return frame;
  });
}

std::string summaryJson(const ModelSummary& summary) {
  const glm::dvec3 min =
      summary.box.empty() ? summary.lattice.origin : summary.lattice.toWorld(summary.box.min);
  const glm::dvec3 max =
      summary.box.empty() ? summary.lattice.origin : summary.lattice.toWorld(summary.box.max);
  return Json{{"name", summary.name},
              {"build_id", toHex(summary.build_id)},
              {"triangles", summary.triangles},
              {"bytes", summary.bytes},
              {"depth", summary.depth},
              {"nodes", summary.nodes},
              {"has_textures", static_cast<bool>(summary.textures)},
              {"has_colours", summary.attributes.has(AttributeSet::kColour)},
              {"step", summary.lattice.step},
              {"origin", toJson(summary.lattice.origin)},
              {"min", toJson(min)},
              {"max", toJson(max)},
              {"size_model", glm::distance(min, max)}}
      .dump(-1, ' ', true);
}

std::string frameJson(WebModel& model, const FrameInput& frame, bool with_parts) {
  const app::CameraRig& rig = model.rig();
  const core::CameraKey camera = rig.camera();
  const core::View& view = rig.view();
  Json json{
      {"kind", nameOf(rig.kind())},
      {"moving", rig.isMoving()},
      {"parallel", rig.isParallel()},
      {"camera",
       {{"eye", toJson(camera.eye)},
        {"target", toJson(camera.target)},
        {"up", toJson(camera.up)},
        {"fov_y_deg", glm::degrees(view.fov_y_rad)}}},
      {"units_per_px", 2 * std::tan(view.fov_y_rad / 2) * rig.distanceModel() / std::max(1u, view.height_px)},
      {"serial", model.serial()},
      {"uniforms", uniformsOf(model, frame)},
      {"status", statusOf(model, frame)}};
  if (with_parts) {
    Json parts = Json::array();
    for (const DrawnPart& part : model.parts()) parts.push_back({part.id, part.flags, part.tint});
    json["parts"] = std::move(parts);
    Json legend = Json::array();
    for (const render::LegendEntry& entry : render::legendOf(frame.show, model.items(), frame.threshold_px))
      legend.push_back({hexOf(entry.colour), entry.meaning});
    json["legend"] = std::move(legend);
  }
  return json.dump(-1, ' ', true);
}

std::string pickJson(const WebPick& pick) {
  return Json{{"point", toJson(pick.point)}, {"off_model", pick.off}}.dump();
}

std::string projectJson(const WebModel& model, std::string_view points) {
  return reading(points, [&](const Json& json) {
    const core::View& view = model.rig().view();
    const glm::dmat3 rotation(render::viewRotation(view));
    Json places = Json::array();
    for (const Json& point : json) {
      const glm::dvec3 seen = rotation * (vectorOf(point) - model.origin() - view.eye_model);
      const double depth = std::max(-seen.z, 1e-300), focal_px = core::focalPx(view);
      places.push_back({view.width_px / 2.0 + focal_px * seen.x / depth,
                        view.height_px / 2.0 - focal_px * seen.y / depth, seen.z < 0 ? 1 : 0});
    }
    return places.dump();
  });
}

std::string errorJson(std::string_view error, bool is_final) {
  return Json{{"error", error}, {"final", is_final}}.dump(-1, ' ', true, Json::error_handler_t::replace);
}

}  // namespace lode::web
