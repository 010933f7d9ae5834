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
#include "client/core/cache/postponed_blobs.h"
#include "client/core/lod/hierarchy.h"
#include "client/core/lod/request.h"
#include "client/core/textures/texture_stream.h"
#include "common/codec/model_summary.h"

namespace lode::core {

constexpr uint64_t kHierarchyBudgetShare = 8;  ///< the node hierarchy may take 1/8 of the memory budget
/// Blobs in transit (requested, or received but not decoded) may take 1/16 of the memory budget, and running
/// decode jobs another 1/16. A single blob may exceed its share.
constexpr uint64_t kTransitBudgetShare = 16;
/// Upper limit for the share of blobs in transit, and for the share of decode jobs.
constexpr uint64_t kMaxTransitBytes = 64ull << 20;

/// Bytes by which the root's coarsest LOD, which is always loaded, may exceed the memory budget.
constexpr uint64_t kMaxFirstLodExcessBytes = 32ull << 20;
/// Largest number of lost blobs that a model remembers. When it is reached, the model forgets them all, and
/// they may be requested again.
constexpr size_t kMaxRefusedBlobs = 65'536;

/// The resident data of one build of a model: hierarchy, meshes and textures. The caller passes in blobs from
/// any source, runs the decode jobs and returns their results. All views share one Model, which depends on no
/// view and no connection. Not thread safe.
class Model {
 public:
  /// @param memory_budget_bytes  limit for the hierarchy, blobs in transit, decoding, meshes and textures
  ///                             together.
  Model(ModelSummary summary, uint64_t memory_budget_bytes);

  /// Changes the memory budget. Increments version(), so that views refine again.
  void setMemoryBudget(uint64_t bytes);

  const ModelSummary& summary() const noexcept { return summary_; }
  const Hierarchy& hierarchy() const noexcept { return hierarchy_; }
  Hierarchy& hierarchy() noexcept { return hierarchy_; }
  /// Returns the memory budget for all loaded pages of the hierarchy, whether a view uses them or not.
  uint64_t hierarchyBudgetBytes() const noexcept { return hierarchy_budget_bytes_; }
  MeshCache& meshes() noexcept { return meshes_; }
  const MeshCache& meshes() const noexcept { return meshes_; }
  /// Returns the textures; null if the model has no textures.
  TextureStream* textures() noexcept { return textures_ ? &*textures_ : nullptr; }
  const TextureStream* textures() const noexcept { return textures_ ? &*textures_ : nullptr; }

  /// Returns the request that precedes all others: for the root page, or for the root's coarsest LOD once the
  /// page is loaded. Returns nothing if both are resident, or if the blob is being decoded, lost or
  /// postponed.
  std::optional<Request> firstRequest() const;
  /// Returns true if the blob may be requested: it is not being decoded, lost or postponed.
  bool wants(const Request& request) const;

  /// Stores a blob or queues it for decoding. While undecodedBytes() exceeds transitBudgetBytes(), drops
  /// meshes and tiles instead, and they may be requested again. More bytes than the budget can arrive if
  /// cancelled requests complete, or if several nodes share a payload. @param bytes  bytes that match the
  /// blob's digest.
  /// @throws Error kFormat or kLimit for an invalid page or texture set, and kLimit if the root's coarsest
  /// LOD exceeds the memory budget by more than kMaxFirstLodExcessBytes.
  void take(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  /// Notes that a blob is lost for good. Refinement uses other LODs or nodes instead.
  void lose(const BlobRef& blob, const std::string& why);
  /// Notes that the server refuses a blob for now. wants() returns false for it until a pause is over: see
  /// PostponedBlobs.
  void postpone(const BlobRef& blob, const std::string& why, TimePoint now);
  /// Allows postponed blobs to be requested again if their pause is over. @return true if there are blobs to
  /// request again.
  bool releasePostponed(TimePoint now) { return postponed_.release(now); }

  /// Returns the waiting jobs that fit the memory for decoding. Call again after each finishDecode() to get
  /// more jobs.
  std::vector<DecodeJob> takeDecodeJobs();
  /// Stores the result of a decode job; ignores results of another build.
  void finishDecode(DecodeResult result);

  /// Returns the first 8 bytes of the build id, which identify the build.
  uint64_t build() const noexcept;
  /// Returns a number that increases with every change that may affect a cut.
  uint64_t version() const noexcept { return version_; }
  /// Returns the reason why a part of the model cannot be loaded; empty if no part has failed.
  const std::string& failure() const noexcept { return failure_.empty() ? postponed_.why() : failure_; }
  /// Returns true if parts have failed, but all of them are only postponed.
  bool failureMayPass() const noexcept { return failure_.empty() && !postponed_.why().empty(); }
  /// Returns the encoded size of the received blobs that are not decoded yet.
  uint64_t undecodedBytes() const noexcept { return undecoded_bytes_; }
  /// Returns an estimate of the memory of the running decode jobs.
  uint64_t decodingBytes() const noexcept { return decoding_bytes_; }
  /// Returns the budget for blobs that are requested, or received but not decoded.
  uint64_t transitBudgetBytes() const noexcept { return transit_budget_bytes_; }
  size_t decoding() const noexcept { return decoding_.size(); }
  /// Returns the encoded size of all texture blobs received so far.
  uint64_t textureBlobBytes() const noexcept { return texture_blob_bytes_; }

 private:
  /// Identifies a decode job. LODs of a node that share a payload also share the job.
  struct Decoding {
    BlobKind kind;
    NodeKey node;
    uint32_t blob;
    friend constexpr auto operator<=>(const Decoding&, const Decoding&) = default;
  };

  struct Work {
    BlobRef blob;
    uint64_t bytes = 0;  // memory that decoding takes; 0 while the job waits
  };

  void addPage(const BlobUse& use, std::span<const std::byte> bytes);
  void requireRoomFor(const Lod& first) const;
  void startDecode(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  void insert(DecodeResult result);
  MeshKey coarsest() const;
  static Decoding toDecoding(const BlobRef& blob, const BlobUse& use) noexcept {
    return {use.kind, use.mesh.node, blob.number};
  }

  ModelSummary summary_;
  Hierarchy hierarchy_;
  uint64_t memory_budget_bytes_ = 0, hierarchy_budget_bytes_ = 0;
  MeshCache meshes_;
  std::optional<TextureStream> textures_;
  std::map<Decoding, Work> decoding_;  // jobs that wait or run
  uint64_t transit_budget_bytes_ = 0;
  uint64_t undecoded_bytes_ = 0, decoding_bytes_ = 0;
  std::deque<DecodeJob> jobs_;  // jobs that wait for takeDecodeJobs()
  std::set<uint32_t> lost_;     // numbers of the lost blobs
  PostponedBlobs postponed_;
  uint64_t texture_blob_bytes_ = 0;
  uint64_t version_ = 0;
  std::string failure_;  // reason for the first loss of a blob
};

}  // namespace lode::core
