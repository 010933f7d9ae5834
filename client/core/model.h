#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/core/cache/decode_job.h"
#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/hierarchy.h"
#include "client/core/lod/request.h"
#include "client/core/textures/texture_stream.h"
#include "common/codec/model_summary.h"

namespace lode::core {

constexpr uint64_t kHierarchyBudgetShare = 8;  ///< the hierarchy gets 1/8 of the memory budget
/// Blobs that are requested or wait to be decoded get 1/16 of the memory budget, and decoders as much again.
/// A single blob may exceed its share.
constexpr uint64_t kTransitBudgetShare = 16;
constexpr uint64_t kMaxTransitBytes = 64ull << 20;  ///< upper limit of either share

/// The resident data of one build of a model: hierarchy, meshes and textures. Takes blobs from any source,
/// returns decode jobs and takes their results. All views share it; it depends on no view and no connection.
/// Not thread safe.
class Model {
 public:
  /// @param memory_budget_bytes  for hierarchy, blobs in transit, decoding, meshes and textures.
  Model(ModelSummary summary, uint64_t memory_budget_bytes);

  /// Changes the budget and the version, so that views refine again.
  void setMemoryBudget(uint64_t bytes);

  const ModelSummary& summary() const noexcept { return summary_; }
  const Hierarchy& hierarchy() const noexcept { return hierarchy_; }
  Hierarchy& hierarchy() noexcept { return hierarchy_; }
  /// Budget of the hierarchy: pages in use, then recently used pages.
  uint64_t hierarchyBudgetBytes() const noexcept { return hierarchy_budget_bytes_; }
  MeshCache& meshes() noexcept { return meshes_; }
  const MeshCache& meshes() const noexcept { return meshes_; }
  /// Null if the model has no textures.
  TextureStream* textures() noexcept { return textures_ ? &*textures_ : nullptr; }
  const TextureStream* textures() const noexcept { return textures_ ? &*textures_ : nullptr; }

  /// The request that precedes any view: the root page, then the root's coarsest LOD; nothing once both are
  /// resident or being decoded.
  std::optional<Request> firstRequest() const;
  /// Returns true if a request makes sense: the blob is not being decoded and was not refused.
  bool wants(const Request& request) const;

  /// Takes the bytes of a blob. @param bytes  must match the digest.
  /// @throws Error kFormat or kLimit for an invalid page or texture set.
  void take(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  /// Notes that a blob cannot be loaded. @param is_lost  permanently, so that refinement works around it.
  void refuse(const BlobRef& blob, const std::string& why, bool is_lost = true);

  /// Returns the waiting jobs that fit the decoding budget; the rest follow after finishDecode().
  std::vector<DecodeJob> takeDecodeJobs();
  /// Takes a job's result; ignores results of another build.
  void finishDecode(DecodeResult result);

  /// Identifies the build: the first 8 bytes of its build id.
  uint64_t build() const noexcept;
  /// Increases with every change that may change a cut.
  uint64_t version() const noexcept { return version_; }
  /// Why some part of the model cannot be loaded; empty if none failed.
  const std::string& failure() const noexcept { return failure_; }
  /// Encoded size of received blobs that are not decoded yet, and memory of the running decoders.
  uint64_t undecodedBytes() const noexcept { return undecoded_bytes_; }
  uint64_t decodingBytes() const noexcept { return decoding_bytes_; }
  /// Budget for requested and undecoded blobs.
  uint64_t transitBudgetBytes() const noexcept { return transit_budget_bytes_; }
  size_t decoding() const noexcept { return decoding_.size(); }
  /// Size of all received texture blobs.
  uint64_t textureBlobBytes() const noexcept { return texture_blob_bytes_; }

 private:
  /// Identifies a decode job; LODs of a node that share a payload share the job.
  struct Decoding {
    BlobKind kind;
    NodeKey node;
    uint32_t blob;
    friend constexpr auto operator<=>(const Decoding&, const Decoding&) = default;
  };

  struct Work {
    BlobRef blob;
    uint64_t bytes = 0;  // memory for decoding; 0 until the job is handed out
  };

  void addPage(const BlobUse& use, std::span<const std::byte> bytes);
  void startDecode(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  void insert(DecodeResult result);
  MeshKey coarsest() const;
  static Decoding toDecoding(const BlobRef& blob, const BlobUse& use) noexcept {
    return {use.kind, use.mesh.node, blob.number};
  }

  ModelSummary summary_;
  Hierarchy hierarchy_;
  uint64_t hierarchy_budget_bytes_ = 0;
  MeshCache meshes_;
  std::optional<TextureStream> textures_;
  std::map<Decoding, Work> decoding_;  // jobs handed out or waiting
  uint64_t transit_budget_bytes_ = 0;
  uint64_t undecoded_bytes_ = 0, decoding_bytes_ = 0;
  std::deque<DecodeJob> jobs_;  // waiting to be handed out
  std::set<uint32_t> refused_;  // blob numbers
  uint64_t texture_blob_bytes_ = 0;
  uint64_t version_ = 0;
  std::string failure_;
};

}  // namespace lode::core
