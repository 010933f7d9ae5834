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

constexpr uint64_t kHierarchyBudgetShare = 8;  ///< the hierarchy may use 1/8 of the memory budget
/// Blobs that are requested or not decoded yet may use 1/16 of the memory budget, and the decoders another
/// 1/16. A single blob may exceed this share.
constexpr uint64_t kTransitBudgetShare = 16;
/// Upper limit for each of the two shares of kTransitBudgetShare.
constexpr uint64_t kMaxTransitBytes = 64ull << 20;

/// The root's coarsest LOD may exceed the memory budget by this much.
constexpr uint64_t kMaxFirstLodExcessBytes = 32ull << 20;
/// Largest number of remembered refusals. Above this number, the model forgets all refusals, and their blobs
/// may be requested again.
constexpr size_t kMaxRefusedBlobs = 65'536;

/// The resident data of one build of a model: hierarchy, meshes and textures. The caller passes in blobs from
/// any source, runs the decode jobs and returns their results. All views share one Model, which depends on no
/// view and no connection. Not thread safe.
class Model {
 public:
  /// @param memory_budget_bytes  limit for the hierarchy, blobs in transit, decoding, meshes and textures
  ///                             together.
  Model(ModelSummary summary, uint64_t memory_budget_bytes);

  /// Changes the budget and the version, so that views refine again.
  void setMemoryBudget(uint64_t bytes);

  const ModelSummary& summary() const noexcept { return summary_; }
  const Hierarchy& hierarchy() const noexcept { return hierarchy_; }
  Hierarchy& hierarchy() noexcept { return hierarchy_; }
  /// Memory budget of the hierarchy's pages, both pages in use and recently used pages.
  uint64_t hierarchyBudgetBytes() const noexcept { return hierarchy_budget_bytes_; }
  MeshCache& meshes() noexcept { return meshes_; }
  const MeshCache& meshes() const noexcept { return meshes_; }
  /// Returns the textures; null if the model has no textures.
  TextureStream* textures() noexcept { return textures_ ? &*textures_ : nullptr; }
  const TextureStream* textures() const noexcept { return textures_ ? &*textures_ : nullptr; }

  /// Returns the request to send while no view is set. The request is for the root page, then for the root's
  /// coarsest LOD. Returns nothing if both are resident, or if the next blob is being decoded, lost or
  /// postponed.
  std::optional<Request> firstRequest() const;
  /// Returns true if the blob should be requested: it is neither being decoded, lost nor postponed.
  bool wants(const Request& request) const;

  /// Stores a blob or queues it for decoding. @param bytes  bytes that match the blob's digest.
  /// @throws Error kFormat or kLimit for an invalid page or texture set, and kLimit if the root's coarsest
  /// LOD exceeds the memory budget by more than kMaxFirstLodExcessBytes.
  void take(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  /// Notes that a blob is lost for good. Refinement uses other LODs or nodes instead.
  void lose(const BlobRef& blob, const std::string& why);
  /// Notes that the server refuses a blob for now. wants() returns false for this blob until a pause is over.
  void postpone(const BlobRef& blob, const std::string& why, TimePoint now);
  /// Ends the pause of postponed blobs when it is over. @return true if there are blobs to request again.
  bool releasePostponed(TimePoint now) { return postponed_.release(now); }

  /// Returns the waiting jobs that fit the decoding budget. Call the function again after each
  /// finishDecode(), to get further jobs.
  std::vector<DecodeJob> takeDecodeJobs();
  /// Stores the result of a decode job; ignores results of another build.
  void finishDecode(DecodeResult result);

  /// Returns the first 8 bytes of the build id, which identify the build.
  uint64_t build() const noexcept;
  /// Returns a number that increases with every change that may affect a cut.
  uint64_t version() const noexcept { return version_; }
  /// Reason why a part of the model cannot be loaded; empty if no part has failed.
  const std::string& failure() const noexcept { return failure_.empty() ? postponed_.why() : failure_; }
  /// Returns true if all parts that have failed are only postponed.
  bool failureMayPass() const noexcept { return failure_.empty() && !postponed_.why().empty(); }
  /// Encoded size of the received blobs that are not decoded yet.
  uint64_t undecodedBytes() const noexcept { return undecoded_bytes_; }
  /// Memory of the running decode jobs.
  uint64_t decodingBytes() const noexcept { return decoding_bytes_; }
  /// Budget for requested and undecoded blobs.
  uint64_t transitBudgetBytes() const noexcept { return transit_budget_bytes_; }
  size_t decoding() const noexcept { return decoding_.size(); }
  /// Size of all received texture blobs.
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
    uint64_t bytes = 0;  // memory that decoding takes; 0 until takeDecodeJobs() returns the job
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
  std::map<Decoding, Work> decoding_;  // jobs that wait, and jobs that takeDecodeJobs() has returned
  uint64_t transit_budget_bytes_ = 0;
  uint64_t undecoded_bytes_ = 0, decoding_bytes_ = 0;
  std::deque<DecodeJob> jobs_;  // jobs that wait for takeDecodeJobs()
  std::set<uint32_t> lost_;     // numbers of the lost blobs
  PostponedBlobs postponed_;
  uint64_t texture_blob_bytes_ = 0;
  uint64_t version_ = 0;
  std::string failure_;  // reason why the first lost blob is lost
};

}  // namespace lode::core
