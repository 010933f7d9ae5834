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
#include "client/render/draw_item.h"
#include "client/render/residency/cut_exchange.h"
#include "client/render/residency/gpu_pages.h"
#include "client/render/residency/staging_ring.h"
#include "client/render/shown_colours.h"

namespace lode::render {

struct ResidencyOptions {
  uint64_t budget_bytes = uint64_t{1} << 30;            ///< of GPU memory for meshes
  uint64_t texture_budget_bytes = uint64_t{256} << 20;  ///< of GPU memory for textures
  uint64_t spare_bytes = uint64_t{128} << 20;           ///< kept of meshes that are no longer drawn
  uint32_t page_bytes = 32u << 20;                      ///< of one buffer
  uint32_t staging_bytes = 4u << 20;                    ///< most that one frame uploads of meshes
  uint32_t texture_staging_bytes = 4u << 20;            ///< and of tiles: kLeastTextureStagingBytes at least
};

/// How much of a frame may go into uploads.
struct UploadBudget {
  uint32_t bytes = 4u << 20;
  double ms = 2.0;
  bool wait = false;  ///< go on, waiting for the GPU, until the newest cut is there: for off-screen pictures
};

/// Which meshes of a model are on the GPU, and what is drawn of them at the places where it stands. Of a
/// newer cut a region is drawn when all of it is there, and until then what was drawn there before: what
/// arrives slowly never leaves a hole, wherever the camera goes. A cut of another build is exchanged as a
/// whole. Meshes are known by their shared_ptr's identity and not kept alive. Used on the thread of its
/// context.
class MeshResidency {
 public:
  /// @throws Error kIo if there is no memory for uploads.
  explicit MeshResidency(const ResidencyOptions& options);

  /// Another budget from now on; what is drawn stays.
  void setBudget(uint64_t bytes) noexcept;
  /// See ResidencyOptions.
  void setSpare(uint64_t bytes) noexcept { options_.spare_bytes = bytes; }
  /// The newest cuts. They are begun when a region of those under way has taken its place, however fast newer
  /// ones follow; much coarser ones at once.
  void show(std::shared_ptr<const core::ViewCuts> cuts) { newest_ = std::move(cuts); }
  /// The newest cut of a model that stands in one place.
  void show(const std::shared_ptr<const core::Cut>& cut);
  /// Uploads towards the newest cuts, within the budget. @return bytes uploaded.
  uint64_t uploadInRenderThread(const UploadBudget& budget);

  /// The newest cuts are those drawn.
  bool upToDate() const noexcept { return newest_ == complete_; }
  /// The newest cuts do not fit into the budget: what was there before stays.
  bool overBudget() const noexcept { return rejected_ != nullptr && rejected_ == newest_; }
  const std::shared_ptr<const core::ViewCuts>& newest() const noexcept { return newest_; }
  /// The last cuts that something was drawn of before those under way; of none under way, those drawn.
  const std::shared_ptr<const core::ViewCuts>& before() const noexcept { return before_; }
  /// How many places something is drawn at.
  size_t placeCount() const noexcept { return instances_.size(); }
  /// A cut that was shown, or a mixture of such: see CutExchange. Null before the first, and while room is
  /// made for one that fits only alone.
  const std::shared_ptr<const core::Cut>& drawnCut(size_t instance = 0) const noexcept;
  /// By the numbers of core::partOf(): the drawn cut's parts, and what is drawn instead where it lacks some.
  std::span<const DrawItem> drawn(size_t instance = 0) const noexcept;
  /// Of the drawn cuts; later ones' is larger.
  uint64_t drawnSerial() const noexcept { return drawn_serial_; }
  /// The mixtures made by the last upload. They may be the last to have a mesh: who gives them to the thread
  /// that frees cuts spares this one the work.
  std::vector<std::shared_ptr<const core::Cut>> takeMixtures() { return std::exchange(mixtures_, {}); }
  static constexpr uint64_t kNone = std::numeric_limits<uint64_t>::max();
  /// Meshes of cuts drawn since this one stay while there is room, for what still shows them; keptFrom()
  /// tells since which they have. @param serial  drawnSerial() of some time, or kNone.
  void keepFrom(uint64_t serial);
  uint64_t keptFrom() const noexcept { return kept_from_; }
  const GpuPages& pages() const noexcept { return pages_; }
  size_t meshCount() const noexcept { return entries_.size(); }
  /// That uploads go through.
  uint64_t stagingBytes() const noexcept { return uint64_t{StagingRing::kSegments} * options_.staging_bytes; }

 private:
  struct Entry {
    GpuBlock block;
    LatticeBox box;
    std::shared_ptr<MeshClusters> clusters;
    uint64_t used_by = 0;  ///< serial of the last cut that has it
    uint32_t vertices_done = 0, triangles_done = 0, clusters_done = 0;
    bool complete = false;
  };
  /// What is drawn where the model stands once.
  struct DrawnInstance {
    std::shared_ptr<const core::Cut> cut;
    std::vector<DrawItem> drawn;
    std::vector<Entry*> entries;  ///< of what is drawn
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
  Entry* instance(const std::shared_ptr<const Mesh>& mesh);
  bool makeRoomForTargetAlone();
  void reject();
  void drawWhatIsThere();
  void endExchange();
  void list(DrawnInstance& instance, std::shared_ptr<const core::Cut> cut);
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
  std::shared_ptr<const core::ViewCuts> complete_;  ///< drawn at all places; null where cuts are mixed
  std::vector<DrawnInstance> instances_;
  std::optional<CutExchange> exchange_;      ///< to target_
  size_t steps_done_ = 0, steps_drawn_ = 0;  ///< of exchange_
  size_t next_in_step_ = 0;                  ///< of the step after those done
  bool has_room_alone_ = false;              ///< target_: all else was given up for it
  uint64_t serial_ = 0, target_serial_ = 0, drawn_serial_ = 0;
  uint64_t kept_from_ = kNone;
  std::vector<std::shared_ptr<const core::Cut>> mixtures_;  ///< of the last upload
};

}  // namespace lode::render
