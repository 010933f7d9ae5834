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

constexpr uint64_t kHierarchyBudgetShare = 8;  ///< one in so many bytes of memory is for what is known
/// And one in so many for blobs that are asked for or wait to be decoded, as many again for decoding. One
/// alone may be larger.
constexpr uint64_t kTransitBudgetShare = 16;
constexpr uint64_t kMaxTransitBytes = 64ull << 20;  ///< of either, however large the budget

/// One build of a model, as far as it is known and resident: its hierarchy, meshes and textures. Blobs go in,
/// wherever they come from; decode jobs come out, and their results go in. Knows no view and no connection;
/// every view of the model shares it. Not thread safe.
class Model {
 public:
  /// @param memory_budget_bytes  of the hierarchy, blobs on their way, decoding, meshes and textures.
  Model(ModelSummary summary, uint64_t memory_budget_bytes);

  /// Another budget from now on: views are refined anew.
  void setMemoryBudget(uint64_t bytes);

  const ModelSummary& summary() const noexcept { return summary_; }
  const Hierarchy& hierarchy() const noexcept { return hierarchy_; }
  Hierarchy& hierarchy() noexcept { return hierarchy_; }
  /// For the pages that a view needs, and beyond them for those that it does not.
  uint64_t hierarchyBudgetBytes() const noexcept { return hierarchy_budget_bytes_; }
  MeshCache& meshes() noexcept { return meshes_; }
  const MeshCache& meshes() const noexcept { return meshes_; }
  /// Null: it has none.
  TextureStream* textures() noexcept { return textures_ ? &*textures_ : nullptr; }
  const TextureStream* textures() const noexcept { return textures_ ? &*textures_ : nullptr; }

  /// What comes before any view: the root's page, then its coarsest LOD; nothing once they are there or
  /// being decoded.
  std::optional<Request> firstRequest() const;
  /// Whether a blob would help: it is not being decoded and not refused.
  bool wants(const Request& request) const;

  /// Takes the bytes of a blob, whose name was checked. @throws Error kFormat or kLimit for a page or texture
  /// set that breaks a rule.
  void take(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  /// A blob cannot be had. @param is_lost  for good, so that something else is to take its place.
  void refuse(const BlobRef& blob, const std::string& why, bool is_lost = true);

  /// Those that there is memory for; others follow when these have come back.
  std::vector<DecodeJob> takeDecodeJobs();
  /// Takes a job's result; one that belongs to another build is dropped.
  void finishDecode(DecodeResult result);

  /// Names it among the builds of one model.
  uint64_t build() const noexcept;
  /// Grows with every change that a view may show.
  uint64_t version() const noexcept { return version_; }
  /// Why a part of the model cannot be had; empty if nothing is wrong.
  const std::string& failure() const noexcept { return failure_; }
  /// Of blobs that have come and are not decoded, and what those take that are being decoded.
  uint64_t undecodedBytes() const noexcept { return undecoded_bytes_; }
  uint64_t decodingBytes() const noexcept { return decoding_bytes_; }
  /// For blobs that are asked for or not decoded yet.
  uint64_t transitBudgetBytes() const noexcept { return transit_budget_bytes_; }
  size_t decoding() const noexcept { return decoding_.size(); }
  /// Of all texture blobs that came.
  uint64_t textureBlobBytes() const noexcept { return texture_blob_bytes_; }

 private:
  /// What is being decoded: of a mesh, the same for all LODs of a node that share the payload.
  struct Decoding {
    BlobKind kind;
    NodeKey node;
    uint32_t blob;
    friend constexpr auto operator<=>(const Decoding&, const Decoding&) = default;
  };

  /// What is being decoded, and what that takes.
  struct Work {
    BlobRef blob;
    uint64_t bytes = 0;  // while it is handed out; 0 before
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
  std::map<Decoding, Work> decoding_;  // handed out or waiting for that
  uint64_t transit_budget_bytes_ = 0;
  uint64_t undecoded_bytes_ = 0, decoding_bytes_ = 0;
  std::deque<DecodeJob> jobs_;  // not handed out yet
  std::set<uint32_t> refused_;  // blob numbers
  uint64_t texture_blob_bytes_ = 0;
  uint64_t version_ = 0;
  std::string failure_;
};

}  // namespace lode::core
