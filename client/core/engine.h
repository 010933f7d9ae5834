#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/core/cache.h"
#include "client/core/cut.h"
#include "client/core/hierarchy.h"
#include "client/core/refiner.h"
#include "client/core/session.h"
#include "client/core/texture_stream.h"
#include "client/core/view.h"
#include "common/draco_codec.h"

namespace lode::core {

constexpr uint64_t kDefaultMemoryBudgetBytes = 1ull << 30;  ///< of decoded meshes and textures

struct EngineOptions {
  SessionOptions session;
  uint64_t memory_budget_bytes = kDefaultMemoryBudgetBytes;
  uint64_t triangle_budget = std::numeric_limits<uint64_t>::max();
};

/// A tile that a job decodes instead of a mesh.
struct TileOrder {
  uint32_t blob = 0;
  glm::uvec2 image_size{0};
  bool with_tail = false;  ///< it is a coarsest level: see tile_tail.h
};

/// A payload to be decoded outside the core, on any thread: decodePayload(bytes, step, expected), and the
/// footprint of the mesh where textures are known; or a tile: decodeTile(bytes, image_size), and its tail.
struct DecodeJob {
  MeshKey mesh;
  std::vector<std::byte> bytes;
  double step = 1;
  PayloadExpectation expected;
  std::shared_ptr<const TextureSet> textures = nullptr;
  std::optional<TileOrder> tile = std::nullopt;
};

struct DecodeResult {
  MeshKey mesh;
  std::shared_ptr<const Mesh> decoded;  ///< null if it failed
  std::string failure;                  ///< then: why
  std::shared_ptr<const TextureFootprint> footprint = nullptr;
  std::optional<TileOrder> tile = std::nullopt;  ///< of a tile's job
  std::shared_ptr<const TileImage> image = nullptr;
};

/// Runs a job; never throws.
DecodeResult runDecodeJob(const DecodeJob& job);

struct EngineCounts {
  uint64_t received_bytes = 0;  ///< everything from the server
  uint64_t open_wishes = 0;
  uint64_t decoding = 0;        ///< jobs handed out
  uint64_t resident_bytes = 0;  ///< decoded meshes
  uint64_t known_nodes = 0;
  uint64_t texture_blob_bytes = 0;  ///< received for textures: their set and tiles
  uint64_t texture_bytes = 0;       ///< decoded tiles
  uint64_t tiles = 0;               ///< resident
  uint64_t tiles_left_out = 0;      ///< that the view needs and the memory budget does not allow
};

/// Session, caches and refiner stepped together: bytes, decoded meshes and tiles and a camera in; bytes,
/// decode jobs and cuts out. Owns no thread, knows no clock and no socket. Not thread safe; the cuts it gives
/// are.
class Engine {
 public:
  Engine(EngineOptions options, TimePoint now);

  /// @throws Error as Session does: the engine must be given up then; the last cut stays good.
  void receive(std::span<const std::byte> bytes, TimePoint now);
  void finishDecode(DecodeResult result);
  /// @param view  in the model frame: see camera_path.h for how to come from true coordinates.
  void setView(const View& view, float threshold_px);

  /// Refines if anything has changed, renews the wishes, keeps the connection alive.
  void step(TimePoint now);

  proto::Bytes takeOutgoing() { return session_.takeOutgoing(); }
  std::vector<DecodeJob> takeDecodeJobs() { return std::exchange(jobs_, {}); }

  /// Null until the model is open.
  const ModelSummary* summary() const noexcept { return summary_ ? &*summary_ : nullptr; }
  /// The last cut published; null until the root's coarsest rung is there and a view is set.
  const std::shared_ptr<const Cut>& cut() const noexcept { return cut_; }
  /// Bytes of the blobs that the cut is made of.
  uint64_t cutBlobBytes() const;
  /// A budget keeps the last cut from converging.
  bool limited() const noexcept { return limited_; }
  /// The last cut is all that the view and the budgets will ever give.
  bool settled() const noexcept { return settled_; }
  /// Why a part of the model cannot be had; empty if nothing is wrong.
  const std::string& failure() const noexcept { return failure_; }
  EngineCounts counts() const noexcept;

 private:
  void handle(ModelOpened event);
  void handle(ModelsListed event);
  void handle(BlobArrived event);
  void handle(BlobRefused event);
  void handle(WishCancelled event);
  void handle(ServerLeaving event);
  void handle(ModelChanged event);

  enum class Kind : uint8_t { kMesh, kPage, kRootPage, kTextureSet, kTile };
  struct Purpose {  // of a blob that was wished for
    Kind kind = Kind::kMesh;
    MeshKey mesh;  // or of the node that owns the page
  };
  struct Ask {
    BlobWish wish;
    Purpose purpose;
  };
  void addPage(const Purpose& purpose, std::span<const std::byte> bytes);
  void startDecode(MeshKey mesh, std::vector<std::byte> bytes);
  void startDecode(const BlobRef& tile, std::vector<std::byte> bytes);
  void finishTile(DecodeResult result);
  void dressCut(Cut& cut);
  void collectAsks(const std::vector<Wanted>& wanted);
  void fail(std::string message);
  void renewWishes();

  EngineOptions options_;
  Session session_;
  MeshCache cache_;
  std::optional<ModelSummary> summary_;
  std::optional<Hierarchy> hierarchy_;
  std::optional<View> view_;
  RefineOptions refine_options_;
  bool changed_ = false;
  bool wishes_waiting_ = false;                  // some may be sent that could not be before
  std::map<uint32_t, Purpose> purposes_;         // by blob number
  std::optional<TextureStream> textures_;        // of a model that has any
  std::map<MeshKey, uint64_t> decoding_;         // handed out; size of the encoded payload
  std::map<uint32_t, uint64_t> decoding_tiles_;  // the same, by blob number
  uint64_t undecoded_bytes_ = 0;
  std::set<uint32_t> refused_;  // blob numbers that cannot be had
  std::vector<Ask> asks_;       // best first
  uint64_t texture_blob_bytes_ = 0;
  std::vector<DecodeJob> jobs_;
  std::shared_ptr<const Cut> cut_;
  bool limited_ = false, settled_ = false;
  std::string failure_;
};

}  // namespace lode::core
