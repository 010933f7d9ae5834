#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/render/residency/cut_exchange.h"
#include "client/render/residency/draw_item.h"
#include "client/render/residency/gpu_pages.h"
#include "client/render/residency/staging_ring.h"

namespace lode::render {

struct ResidencyOptions {
  uint64_t budget_bytes = uint64_t{1} << 30;            ///< GPU memory for meshes
  uint64_t texture_budget_bytes = uint64_t{256} << 20;  ///< GPU memory for textures
  /// Limit of GPU memory for meshes that are kept but not drawn.
  uint64_t spare_bytes = uint64_t{128} << 20;
  uint32_t page_bytes = 32u << 20;    ///< default size of a GPU buffer
  uint32_t staging_bytes = 4u << 20;  ///< largest size of the mesh uploads of a frame
  /// Largest size of the texture uploads of a frame; at least kLeastTextureStagingBytes.
  uint32_t texture_staging_bytes = 4u << 20;
};

/// Limits the uploads of one frame.
struct UploadBudget {
  uint32_t bytes = 4u << 20;
  double ms = 2.0;
  bool wait = false;  ///< if true, ignores the limits and blocks until everything is resident
};

/// Keeps meshes of a model's cuts (core::Cut) on the GPU and decides which meshes each instance draws. A
/// region of a newer cut is drawn when all its meshes are resident. Until then the region's old parts are
/// drawn, so that slow uploads leave no holes, even if the camera moves. A cut of another build replaces the
/// drawn cut as a whole. Meshes are identified by their shared_ptr, but the residency does not keep them
/// alive. Use the object on the thread of its OpenGL context.
class MeshResidency {
 public:
  /// @throws Error kIo if there is no memory for the staging ring.
  explicit MeshResidency(const ResidencyOptions& options);

  /// Changes the budget. The drawn meshes stay.
  void setBudget(uint64_t bytes) noexcept;
  /// Sets ResidencyOptions::spare_bytes.
  void setSpare(uint64_t bytes) noexcept { options_.spare_bytes = bytes; }
  /// Sets the newest cuts. If other cuts are being uploaded, their next region is completed before the
  /// uploads switch to the newest cuts, so that each set of cuts makes progress. Much coarser cuts are
  /// uploaded at once.
  void show(std::shared_ptr<const core::ViewCuts> cuts) { newest_ = std::move(cuts); }
  /// Sets the newest cut of a model with one instance.
  void show(const std::shared_ptr<const core::Cut>& cut);
  /// Uploads meshes of the newest cuts within the budget. @return bytes uploaded.
  uint64_t uploadInRenderThread(const UploadBudget& budget);

  /// Frees all meshes and pages. Draws nothing until the next show().
  void release();

  /// Returns true if the newest cuts are drawn.
  bool upToDate() const noexcept { return newest_ == complete_; }
  /// Returns true if the newest cuts do not fit into the budget, so that the previous cuts are still drawn.
  bool overBudget() const noexcept { return rejected_ != nullptr && rejected_ == newest_; }
  const std::shared_ptr<const core::ViewCuts>& newest() const noexcept { return newest_; }
  /// Returns the cuts that were drawn before the cuts in progress. If no cuts are in progress, returns the
  /// drawn cuts.
  const std::shared_ptr<const core::ViewCuts>& before() const noexcept { return before_; }
  /// Returns the drawn cut: a cut passed to show(), or a mixture of two (see CutExchange). Returns null
  /// before the first cut is drawn, and during the upload of a cut that left no room for other meshes.
  const std::shared_ptr<const core::Cut>& drawnCut(size_t instance = 0) const noexcept;
  /// Returns parts and fallbacks of the drawn cut, indexed as in core::partOf().
  std::span<const DrawItem> drawn(size_t instance = 0) const noexcept;
  /// Returns the serial number of the drawn cuts, which grows with each change.
  uint64_t drawnSerial() const noexcept { return drawn_serial_; }
  /// Returns the mixed cuts that the last upload made. A mixed cut may hold the last reference to a mesh, so
  /// release the cut on the thread that frees cuts, not on this thread.
  std::vector<std::shared_ptr<const core::Cut>> takeMixtures() { return std::exchange(mixtures_, {}); }
  static constexpr uint64_t kNone = std::numeric_limits<uint64_t>::max();
  /// Keeps the meshes of all cuts that were drawn with this serial or a larger one, as long as they fit,
  /// because cross-fades may still show them. keptFrom() returns the smallest serial from which on all meshes
  /// were kept.
  /// @param serial  an earlier drawnSerial(), or kNone.
  void keepFrom(uint64_t serial);
  uint64_t keptFrom() const noexcept { return kept_from_; }
  const GpuPages& pages() const noexcept { return pages_; }
  size_t meshCount() const noexcept { return entries_.size(); }
  /// Returns the size of the staging ring.
  uint64_t stagingBytes() const noexcept { return uint64_t{StagingRing::kSegments} * options_.staging_bytes; }

 private:
  struct Entry {
    GpuBlock block;
    LatticeBox box;
    std::shared_ptr<MeshClusters> clusters;
    uint64_t used_by = 0;  ///< serial of the latest cuts that contain this mesh
    uint32_t vertices_done = 0, triangles_done = 0, clusters_done = 0;
    bool complete = false;
  };
  /// State of one instance.
  struct DrawnInstance {
    std::shared_ptr<const core::Cut> cut;
    std::vector<DrawItem> drawn;
    std::vector<Entry*> entries;  ///< entries of the drawn meshes
  };
  struct Allowance;
  using Entries = std::map<std::weak_ptr<const Mesh>, Entry, std::owner_less<>>;

  bool isOvertaken() const noexcept;
  bool begin();
  bool mayMix() const noexcept;
  void startExchange(CutExchange::Cuts from);
  bool advance(Allowance& allowance);
  bool advanceStep(const ExchangeStep& step, Allowance& allowance);
  void makeRoom(Allowance& allowance);
  bool uploadMesh(const Mesh& mesh, Entry& entry, Allowance& allowance);
  uint32_t uploadPiece(const Mesh& mesh, Entry& entry, uint32_t limit_bytes);
  template <typename Element>
  uint32_t uploadNext(std::span<const Element> elements, uint32_t& done, uint32_t limit_bytes, GLuint buffer,
                      uint64_t at);
  Entry* allocate(const std::shared_ptr<const Mesh>& mesh);
  bool makeRoomForTargetAlone();
  void reject();
  void switchToResidentSteps();
  void endExchange();
  void setDrawnCut(DrawnInstance& instance, std::shared_ptr<const core::Cut> cut);
  void trimTo(uint64_t spare_bytes);
  bool evictOldest();
  bool pinned(const Entry& entry) const noexcept;
  void pinDrawn() noexcept;
  void pinTarget();

  ResidencyOptions options_;
  GpuPages pages_;
  StagingRing staging_;
  Entries entries_;
  std::shared_ptr<const core::ViewCuts> newest_, target_, before_, rejected_;
  /// One cut per instance, set while each instance draws its cut and nothing else. Null while an instance
  /// still draws parts of an older cut.
  std::shared_ptr<const core::ViewCuts> complete_;
  std::vector<DrawnInstance> instances_;
  std::optional<CutExchange> exchange_;  ///< plan of the switch to target_
  /// Number of steps of exchange_ whose meshes are resident, and number of these steps that are drawn.
  size_t steps_done_ = 0, steps_drawn_ = 0;
  size_t next_in_step_ = 0;      ///< index of the next part in the current step
  bool has_room_alone_ = false;  ///< true if all other meshes were evicted for target_
  uint64_t serial_ = 0, target_serial_ = 0, drawn_serial_ = 0;
  uint64_t kept_from_ = kNone;
  std::vector<std::shared_ptr<const core::Cut>> mixtures_;  ///< mixed cuts that the last upload made
};

}  // namespace lode::render
