#include "client/web/core/web_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "client/core/textures/texture_wants.h"
#include "client/core/view/framing.h"
#include "client/render/passes/mesh_shaders.h"
#include "client/render/residency/gpu_vertex.h"
#include "common/error.h"

namespace lode::web {
namespace {

/// The near plane is at this fraction of the distance to the nearest surface.
constexpr double kNearShare = 0.5;
/// Threshold at which the cut is the coarsest mesh.
constexpr float kCoarsestPx = 1e9f;

/// Divisor: the texture array may use this part of the memory. The engine's budget for tiles is the same.
constexpr uint64_t kTextureShare = 8;
/// Largest number of layers that every WebGL 2 context has.
constexpr uint64_t kMostLayers = 256;
constexpr uint64_t kLayerBytes = uint64_t{kTilePx} * kTilePx * 4;

uint32_t layersOf(uint64_t bytes) {
  return static_cast<uint32_t>(std::clamp<uint64_t>(bytes / kLayerBytes, 1, kMostLayers));
}

/// Returns the number of layers that hold all tiles of a set.
uint64_t layersOf(const TextureSet& set) {
  uint64_t bytes = 0;
  for (uint32_t texture = 0; texture < set.textures.size(); ++texture)
    for (uint32_t level = 0; level < levelCount(set.textures[texture]); ++level)
      for (uint32_t y = 0; y < tilesDown(set.textures[texture], level); ++y)
        for (uint32_t x = 0; x < tilesAcross(set.textures[texture], level); ++x)
          bytes += core::tileRoomBytes(set, {level, texture, y, x});
  return bytes / kLayerBytes + 1;
}

core::EngineOptions engineOptions(const WebModelOptions& options) {
  core::EngineOptions engine;
  engine.session.model = options.model;
  engine.session.token = options.token;
  engine.session.program = "lodestream-web";
  engine.memory_budget_bytes = options.memory_bytes / 2;
  engine.refine.drawn_budget_bytes = options.memory_bytes / 2;
  engine.refine.hysteresis_factor = core::kHysteresisFactor;
  engine.jitter_seed = options.seed;
  engine.has_cache = options.has_cache;
  engine.prefetch = true;
  return engine;
}

uint32_t packTint(const glm::u8vec3& colour) {
  return colour.r | uint32_t{colour.g} << 8 | uint32_t{colour.b} << 16 | 0xff000000u;
}

/// Returns a lower bound of the distance from the eye to a mesh.
double distanceTo(const Mesh& mesh, const core::CutPart& part, const glm::dvec3& eye_model, double step) {
  const double to_box = core::distanceToBox(eye_model, part.box);
  if (to_box > 0 || mesh.cluster_boxes.empty()) return to_box;
  double nearest = std::numeric_limits<double>::max();
  for (const LatticeBox& box : mesh.cluster_boxes)
    nearest = std::min(nearest, core::distanceToBox(eye_model, core::toModelBox(box, step)));
  return nearest;
}

render::DrawItem itemOf(const core::CutPart& part, const core::Cut& cut) {
  render::DrawItem item;
  item.attributes = part.mesh->attributes;
  item.node = part.node;
  item.lod = part.lod;
  const double focal_px = core::focalPx(cut.view);
  item.error_rad = static_cast<float>(part.error_px / focal_px);
  item.error_model = part.error_model;
  item.threshold_rad = item.complete_rad = static_cast<float>(part.threshold_px / focal_px);
  item.age_s = render::kOldS;
  return item;
}

}  // namespace

WebModel::WebModel(WebModelOptions options)
    : texture_bytes_(options.memory_bytes / kTextureShare),
      engine_(engineOptions(options)),
      tiles_(layersOf(texture_bytes_)) {}

std::optional<Bytes> WebModel::takeJob() {
  if (jobs_.empty())
    for (core::DecodeJob& job : engine_.takeDecodeJobs()) jobs_.push_back(std::move(job));
  if (jobs_.empty()) return std::nullopt;
  const core::DecodeJob job = std::move(jobs_.front());
  jobs_.pop_front();
  const uint32_t number = next_job_++;
  core::DecodeResult& result = running_[number];
  result.blob = job.blob;
  result.use = job.use;
  return encodeJob(number, job);
}

void WebModel::finishJob(std::span<const std::byte> message) {
  ResultMessage answer = decodeResult(message);
  const auto running = running_.find(answer.number);
  if (running == running_.end()) throw Error(ErrorCode::kFormat, "a decode worker answered no open job");
  answer.result.blob = running->second.blob;
  answer.result.use = running->second.use;
  running_.erase(running);
  engine_.finishDecode(std::move(answer.result));
}

std::optional<BlobRef> WebModel::takeCacheQuery() {
  if (queries_.empty())
    for (const BlobRef& blob : engine_.takeCacheQueries()) queries_.push_back(blob);
  if (queries_.empty()) return std::nullopt;
  const BlobRef blob = queries_.front();
  queries_.pop_front();
  asked_.emplace(blob.number, blob);
  return blob;
}

void WebModel::finishCacheQuery(uint32_t number, std::optional<std::span<const std::byte>> bytes) {
  const auto asked = asked_.find(number);
  if (asked == asked_.end()) return;
  const BlobRef blob = asked->second;
  asked_.erase(asked);
  if (bytes && (bytes->size() != blob.bytes || digestOf(*bytes) != blob.digest)) bytes.reset();
  engine_.finishCacheQuery(
      blob, bytes ? std::optional(std::vector<std::byte>(bytes->begin(), bytes->end())) : std::nullopt);
}

std::optional<core::Engine::Arrival> WebModel::takeArrival() {
  if (arrivals_.empty())
    for (core::Engine::Arrival& arrival : engine_.takeArrivals()) arrivals_.push_back(std::move(arrival));
  if (arrivals_.empty()) return std::nullopt;
  core::Engine::Arrival arrival = std::move(arrivals_.front());
  arrivals_.pop_front();
  return arrival;
}

bool WebModel::startCamera(const CameraStart& start) {
  const ModelSummary* const summary = engine_.summary();
  if (summary == nullptr) return false;
  framed_ = *summary;
  core::Framing framing;
  framing.up = start.up;
  framing.aspect = double(start.width_px) / std::max(1u, start.height_px);
  if (!start.path) {
    const auto isResident = [&] { return engine_.cut() && engine_.cut()->parts.size() == 1; };
    if (!isResident()) {
      const core::CameraPath path = core::framingCamera(framed_, framing);
      engine_.setView(
          core::toView(path.keys.front(), path.fov_y_deg, start.width_px, start.height_px, framed_),
          kCoarsestPx);
      return false;
    }
    framing.coarse = engine_.cut()->parts.front().mesh;
  }
  rig_.emplace(framed_, framing, start.path, start.width_px, start.height_px);
  engine_.setView(rig_->view(), start.threshold_px);
  return true;
}

const app::CameraRig& WebModel::rig() const {
  if (!rig_) throw Error(ErrorCode::kUsage, "the model has no camera yet");
  return *rig_;
}

void WebModel::frame(const FrameInput& frame) {
  rig();  // throws without a camera
  followBuild();
  rig_->resize(frame.width_px, frame.height_px);
  app::Input input = frame.input;
  point(input);
  const auto ground = [&](const glm::dvec3& point_model) -> std::optional<app::Ground> {
    const core::CutProbe* const cut = probe();
    return cut == nullptr ? std::nullopt : app::groundBelow(*cut, rig_->view(), point_model, rig_->up());
  };
  rig_->apply(input, frame.seconds, ground);
  engine_.setView(rig_->view(), frame.threshold_px);
  select(frame);
}

/// Keeps the camera at its true coordinates when the server has replaced the model.
void WebModel::followBuild() {
  const ModelSummary& summary = *engine_.summary();
  if (summary.build_id == framed_.build_id) return;
  const core::CameraKey camera = rig_->camera();
  framed_ = summary;
  rig_->lookFrom(camera, glm::degrees(rig_->view().fov_y_rad));
}

/// Applies presses and double clicks to the surface below the pointer.
void WebModel::point(app::Input& input) {
  if (!input.pressed && !input.double_clicked && input.wheel == 0) return;
  const std::optional<core::Hit> found = hit(input.pressed ? input.pressed_px : input.pointer_px);
  if (!found) return;
  if (input.double_clicked && rig_->kind() == app::CameraKind::kWalk) {
    rig_->standAt(found->position_model);
  } else if (input.double_clicked) {
    rig_->flyTo(found->position_model);
  } else {
    rig_->turnAbout(found->position_model);
  }
}

/// Selects the meshes to draw for the current camera.
void WebModel::select(const FrameInput& frame) {
  placeTiles();
  const std::shared_ptr<const core::Cut>& cut = engine_.cut();
  std::vector<DrawnPart> parts;
  std::map<uint32_t, std::shared_ptr<const Mesh>> meshes;
  items_.clear();
  shown_.clear();
  near_model_ = framed_.lattice.step;
  if (cut) {
    const core::View& view = rig_->view();
    shown_ = core::shownParts(*cut, view);
    shown_error_px_ = core::shownErrorPx(*cut, shown_, view);
    const render::ColorModeTraits& mode = render::traitsOf(frame.show);
    const auto threshold_rad = static_cast<float>(core::thresholdRad(*cut));
    double nearest = std::numeric_limits<double>::max();
    for (const uint32_t number : shown_) {
      const core::CutPart& part = core::partOf(*cut, number);
      if (!part.mesh || part.mesh->triangles.empty()) continue;
      const AttributeSet attributes = part.mesh->attributes;
      const render::DrawItem item = itemOf(part, *cut);
      uint32_t flags = render::hasNormals(attributes) ? render::kDrawHasNormals : 0;
      if (attributes.has(AttributeSet::kColour)) flags |= render::kDrawHasColour;
      if (cut->textures && attributes.has(AttributeSet::kTexture)) flags |= render::kDrawTextured;
      flags |= mode.draw_flags;
      uint32_t tint = 0;
      if (mode.colour != nullptr) {
        flags |= render::kDrawTinted;
        tint = packTint(mode.colour(item, threshold_rad, 0));
      }
      const uint32_t id = idOf(part.mesh);
      parts.push_back({id, flags, tint});
      meshes.emplace(id, part.mesh);
      items_.push_back(item);
      nearest = std::min(nearest, distanceTo(*part.mesh, part, view.eye_model, cut->lattice_step));
    }
    if (!parts.empty()) near_model_ = std::max(near_model_, nearest * kNearShare);
  }
  if (parts == parts_) return;
  parts_ = std::move(parts);
  meshes_ = std::move(meshes);
  std::erase_if(ids_, [](const auto& entry) { return entry.first.expired(); });
  ++serial_;
}

/// Places the tiles of the current cut.
void WebModel::placeTiles() {
  const std::shared_ptr<const core::Cut>& cut = engine_.cut();
  if (!cut) return;
  if (cut->textures && cut->textures != tile_set_) {
    tile_set_ = cut->textures;
    uploads_.clear();
    // One spare layer, because cells of different sizes leave gaps.
    tile_layers_ =
        static_cast<uint32_t>(std::min<uint64_t>(layersOf(texture_bytes_), layersOf(*tile_set_) + 1));
    tiles_ = render::TilePlacement(tile_layers_);
  }
  tiles_.show(cut, nullptr);
}

std::optional<WebModel::TileUpload> WebModel::takeTileUpload() {
  while (uploads_.empty() && tiles_.next() != nullptr) {
    const std::shared_ptr<const TileImage> image = tiles_.next()->image;
    const std::span<const render::TileCell> cells = tiles_.place();
    for (size_t i = 0; i < cells.size(); ++i)
      uploads_.push_back({image, i == 0 ? image.get() : &image->coarser[i - 1], cells[i]});
  }
  if (uploads_.empty()) return std::nullopt;
  TileUpload upload = std::move(uploads_.front());
  uploads_.pop_front();
  return upload;
}

/// Returns the id of a mesh. A mesh keeps its id while it is resident, and no other mesh ever gets it.
uint32_t WebModel::idOf(const std::shared_ptr<const Mesh>& mesh) {
  const auto [entry, is_new] = ids_.try_emplace(mesh, next_id_);
  if (is_new) ++next_id_;
  return entry->second;
}

std::shared_ptr<const Mesh> WebModel::mesh(uint32_t id) const {
  const auto found = meshes_.find(id);
  return found == meshes_.end() ? nullptr : found->second;
}

/// Returns the probe of the current cut; null if there is no cut.
const core::CutProbe* WebModel::probe() {
  const std::shared_ptr<const core::Cut>& cut = engine_.cut();
  if (!cut) return nullptr;
  if (!probe_ || probe_->cut() != cut) probe_.emplace(cut, cut->lattice_step);
  return &*probe_;
}

std::optional<core::Hit> WebModel::hit(const glm::dvec2& place_px) {
  const core::CutProbe* const cut = probe();
  if (cut == nullptr) return std::nullopt;
  const core::View& view = rig().view();
  return cut->cast(core::rayThrough(view, place_px), core::shownParts(*cut->cut(), view));
}

std::optional<WebPick> WebModel::pick(const glm::dvec2& place_px) {
  rig();  // throws without a camera
  const std::optional<core::Hit> found = hit(place_px);
  if (!found) return std::nullopt;
  const double step = framed_.lattice.step;
  return WebPick{framed_.lattice.origin + found->position_model,
                 double{found->part->error_model} + step * std::sqrt(3.0) / 2};
}

}  // namespace lode::web
