#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/app/camera/camera_rig.h"
#include "client/core/engine.h"
#include "client/core/lod/cut_probe.h"
#include "client/render/passes/color_mode.h"
#include "client/render/residency/tile_placement.h"
#include "client/web/core/job_codec.h"

namespace lode::web {

struct WebModelOptions {
  std::string model, token;
  uint64_t memory_bytes = 1'000'000'000;  ///< half for the engine, half for the meshes on the GPU
  uint32_t seed = 0;                      ///< seed of the random waits between connection attempts
  bool has_cache = false;                 ///< the page answers cache queries
};

struct CameraStart {
  uint32_t width_px = 1, height_px = 1;
  std::optional<glm::dvec3> up;
  std::optional<core::CameraPath> path;  ///< the first key is the camera; without it, the model is framed
  float threshold_px = 1;
};

/// User input since the last frame, and the state of the page.
struct FrameInput {
  uint32_t width_px = 1, height_px = 1;
  float threshold_px = 1;
  double seconds = 0;  ///< time since the last frame
  render::ColorMode show = render::ColorMode::kSurface;
  app::Input input;
};

/// A mesh to draw, with the same state as a draw call of the desktop client.
struct DrawnPart {
  uint32_t id = 0;
  uint32_t flags = 0, tint = 0;

  bool operator==(const DrawnPart&) const = default;
};

/// A surface point in true coordinates.
struct WebPick {
  glm::dvec3 point{0};
  double off = 0;  ///< bound of the distance to the original surface
};

/// A model in a page: engine, camera, and the list of meshes to draw. The page owns the socket, the decode
/// workers, the cache and the canvas. Not thread safe.
class WebModel {
 public:
  explicit WebModel(WebModelOptions options);

  core::Engine& engine() noexcept { return engine_; }

  /// Returns the message of the next decode job for a worker, or nothing.
  std::optional<Bytes> takeJob();
  /// Stores the result of a job. @throws Error kFormat if the message is damaged or of no job.
  void finishJob(std::span<const std::byte> message);

  /// Returns the next blob to look up in the cache. Answer each with finishCacheQuery().
  std::optional<BlobRef> takeCacheQuery();
  /// @param number  number of the blob. @param bytes  bytes in the cache, if any; checked by their digest.
  void finishCacheQuery(uint32_t number, std::optional<std::span<const std::byte>> bytes);
  /// Returns the next blob to cache, or nothing.
  std::optional<core::Engine::Arrival> takeArrival();

  /// Starts the camera, so that the next step requests the meshes of its view. @return false if the camera
  /// must frame the model and its coarsest mesh is not resident; call again after later steps.
  bool startCamera(const CameraStart& start);
  bool hasCamera() const noexcept { return rig_.has_value(); }
  /// Moves the camera, and selects the meshes to draw. @throws Error kUsage without hasCamera().
  void frame(const FrameInput& frame);

  /// @throws Error kUsage without hasCamera().
  const app::CameraRig& rig() const;
  const glm::dvec3& origin() const noexcept { return framed_.lattice.origin; }
  const std::shared_ptr<const core::Cut>& cut() const noexcept { return engine_.cut(); }
  const std::vector<DrawnPart>& parts() const noexcept { return parts_; }
  const std::vector<render::DrawItem>& items() const noexcept { return items_; }
  /// Returns a number that changes with parts().
  uint64_t serial() const noexcept { return serial_; }
  float shownErrorPx() const noexcept { return shown_error_px_; }
  /// Returns a near distance at which no drawn mesh is clipped.
  double nearModel() const noexcept { return near_model_; }

  /// Returns a mesh of parts(); null for other ids.
  std::shared_ptr<const Mesh> mesh(uint32_t id) const;

  /// Returns where the tiles of the cut are in the page's texture array.
  render::TilePlacement& tiles() noexcept { return tiles_; }
  /// Returns the number of layers that the texture array needs; 0 without textures.
  uint32_t tileLayers() const noexcept { return tile_layers_; }
  /// An image to copy to the texture array.
  struct TileUpload {
    std::shared_ptr<const TileImage> owner;  ///< keeps the image alive
    const TileImage* image = nullptr;
    render::TileCell cell;
  };
  /// Returns the next image to copy, or nothing.
  std::optional<TileUpload> takeTileUpload();

  /// Returns the nearest point at a pixel. @throws Error kUsage without hasCamera().
  std::optional<WebPick> pick(const glm::dvec2& place_px);

 private:
  void followBuild();
  void select(const FrameInput& frame);
  uint32_t idOf(const std::shared_ptr<const Mesh>& mesh);
  void placeTiles();
  void point(app::Input& input);
  const core::CutProbe* probe();
  std::optional<core::Hit> hit(const glm::dvec2& place_px);

  uint64_t texture_bytes_;  // limit of the texture array
  core::Engine engine_;
  std::deque<core::DecodeJob> jobs_;                // jobs that wait for a worker
  std::map<uint32_t, core::DecodeResult> running_;  // jobs at the workers, with their blob and use
  uint32_t next_job_ = 1;
  std::deque<BlobRef> queries_;        // queries that takeCacheQuery() has not returned
  std::map<uint32_t, BlobRef> asked_;  // queries without an answer, by number
  std::deque<core::Engine::Arrival> arrivals_;
  ModelSummary framed_;  // model that the camera rig refers to
  std::optional<app::CameraRig> rig_;
  std::optional<core::CutProbe> probe_;
  std::vector<uint32_t> shown_;  // see core::shownParts()
  std::vector<DrawnPart> parts_;
  std::vector<render::DrawItem> items_;  // parts as the colour modes need them
  std::map<std::weak_ptr<const Mesh>, uint32_t, std::owner_less<>> ids_;
  std::map<uint32_t, std::shared_ptr<const Mesh>> meshes_;  // meshes of parts_
  uint32_t next_id_ = 1;
  render::TilePlacement tiles_;
  uint32_t tile_layers_ = 0;
  std::shared_ptr<const TextureSet> tile_set_;  // texture set for which tile_layers_ was computed
  std::deque<TileUpload> uploads_;
  uint64_t serial_ = 0;
  float shown_error_px_ = 0;
  double near_model_ = 0;
};

}  // namespace lode::web
