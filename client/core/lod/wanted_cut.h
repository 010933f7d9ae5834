#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/hierarchy.h"
#include "client/core/lod/refine_options.h"
#include "client/core/view/view.h"
#include "common/mesh.h"

namespace lode::core {

/// What the wanted cut makes of a node.
enum class Role : uint8_t {
  kPart,      ///< it is in the cut
  kExpanded,  ///< its children are
  kBlocked,   ///< its children should be, but are not known yet
};

struct WantedNode {
  const KnownNode* node = nullptr;
  bool visible = false;
  bool wholly_visible = false;
  bool near = false;  ///< visible, or would be if the camera turned a little
  Role role = Role::kPart;
  uint32_t lod = 0;
  std::optional<uint32_t> cover_lod;          ///< the node is in the covering step at this LOD
  std::optional<bool> children_covered;       ///< for who publishes the cut,
  const MeshCache::Lods* resident = nullptr;  ///< and this
  double distance_model = 0;
  uint64_t below_bytes = 0;  ///< of the wanted cut's payloads near the view, at it and below, as far as known
  uint32_t first_child = 0;  ///< of an expanded node, see WantedCut::children()
  uint32_t held = 0;         ///< place in the last refinement's nodes + 1; 0: it had not come so far
};

/// A mesh of a wanted cut, resident or not, and what it takes: decoded, and where it is drawn.
struct WantedMesh {
  MeshKey key;
  uint64_t bytes = 0, drawn_bytes = 0;
};

/// The cut that a view wants of the known octree, whatever is resident: it starts at the root's coarsest
/// LOD, and the part with the largest projected error gives way to its next finer LOD, or from LOD 0 to
/// its children, until no visible part is above the threshold or a budget is reached. Children begin at their
/// coarsest LOD, visible ones at the coarsest that is no worse than what they replace (far LODs may be).
/// What is lost is passed over for what is finer; a part stays where there is nothing at a place below it.
/// Ties go by node key. Parts outside the view are not refined. Where no budget is reached the order makes no
/// difference to the cut, so that it is tried first in one that needs no queue.
class WantedCut {
 public:
  /// @param held  see held(), of the last refinement; used where the options ask for hysteresis.
  WantedCut(const Hierarchy& hierarchy, double lattice_step, AttributeSet attributes, const View& view,
            const RefineOptions& options, std::span<const HeldNode> held);

  WantedNode& root() { return nodes_.front(); }
  std::span<WantedNode> nodes() { return nodes_; }
  /// Of an expanded node, by octant.
  std::span<WantedNode> children(const WantedNode& wanted) {
    return std::span(nodes_).subspan(wanted.first_child, wanted.node->knownChildren().size());
  }
  /// A node as this view sees it. @param in_sight  it is known to be wholly visible, as its parent is.
  WantedNode place(const KnownNode& node, bool in_sight = false) const;
  float errorPx(const WantedNode& wanted, uint32_t lod) const;

  bool limited() const noexcept { return limited_; }  ///< a budget stopped it above the threshold
  bool blocked() const noexcept { return blocked_; }  ///< a node's children are not known yet
  bool lacks() const noexcept { return lacks_; }      ///< what is lost stopped it above the threshold
  /// Owners of the pages that it goes through.
  const std::vector<NodeKey>& pages() const noexcept { return pages_; }
  std::vector<HeldNode> held() const;
  std::vector<WantedMesh> meshes() const;
  static uint32_t lastLod(const Node& node) { return static_cast<uint32_t>(node.lods.size()) - 1; }
  /// The coarsest that is not lost; the last where all are.
  static uint32_t coarsestLod(const KnownNode& node) { return node.coarsestLod().value_or(lastLod(node)); }

 private:
  /// A part that may have to give way. Largest error first.
  struct Candidate {
    float error_px = 0;
    uint32_t place = 0;
    NodeKey node;
    friend bool operator<(const Candidate& a, const Candidate& b) noexcept {
      return a.error_px != b.error_px ? a.error_px < b.error_px : b.node < a.node;
    }
  };
  struct Totals {
    uint64_t triangles = 0, bytes = 0, drawn_bytes = 0;
    void add(const Lod& lod, AttributeSet attributes);
    void remove(const Lod& lod, AttributeSet attributes);
  };
  /// Of what is below a node in the choice of covers.
  struct Below {
    uint64_t bytes = 0;    // of the wanted cut's payloads near the view
    bool settled = false;  // a covering step was chosen, or not all of it is known yet
  };

  void begin();
  void enqueue(uint32_t place);
  Candidate takeNext();
  void refine();
  bool wasFiner(const WantedNode& wanted) const;
  bool giveWay(const Candidate& candidate);
  bool expand(const Candidate& candidate, const Totals& totals);
  void skipWorse(WantedNode& wanted, float replaced_px) const;
  bool fits(const Candidate& candidate, const Totals& totals);
  void stopAt(const Candidate& candidate);
  Below chooseCovers(WantedNode& wanted);

  const Hierarchy& hierarchy_;
  const double step_;
  const AttributeSet attributes_;
  const Sight sight_;
  const RefineOptions& options_;
  const std::span<const HeldNode> held_;
  std::vector<WantedNode> nodes_;
  bool is_best_first_ = false;
  std::vector<Candidate> open_;  // a heap where it goes best first
  Totals totals_;
  uint64_t page_bytes_ = 0;
  std::vector<NodeKey> pages_;
  bool stopped_ = false;  // by a budget
  bool limited_ = false, blocked_ = false, lacks_ = false;
};

}  // namespace lode::core
