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

/// Role of a node in the wanted cut.
enum class Role : uint8_t {
  kPart,      ///< the node is a part of the cut
  kExpanded,  ///< children replace the node
  kBlocked,   ///< children should replace the node, but their page is not loaded
};

struct WantedNode {
  const KnownNode* node = nullptr;
  bool visible = false;
  bool wholly_visible = false;
  bool near = false;  ///< the node is in the view or its margin
  Role role = Role::kPart;
  uint32_t lod = 0;
  /// LOD of this node that belongs to the covering step of refine(); empty if none does.
  std::optional<uint32_t> cover_lod;
  /// True if resident meshes cover all children; empty until the refiner has tested the children.
  std::optional<bool> children_covered;
  const MeshCache::Lods* resident = nullptr;  ///< resident LODs of the node; set by the refiner
  double distance_model = 0;
  uint64_t below_bytes = 0;  ///< size of the wanted payloads near the view, at this node and below
  uint32_t first_child = 0;  ///< index of the first child if the node is expanded: see children()
  uint32_t held = 0;         ///< 1 + the node's index in the `held` of the constructor; 0 if it is not there
};

/// A mesh of the wanted cut, resident or not, with its decoded size and its GPU memory.
struct WantedMesh {
  MeshKey key;
  uint64_t bytes = 0, drawn_bytes = 0;
};

/// The cut of the known octree that a view needs, regardless of which meshes are resident. Refinement starts
/// at the root's coarsest LOD. The part with the largest projected error is replaced by its next finer LOD,
/// or at LOD 0 by its children, until no visible part exceeds the threshold or a budget is reached. Children
/// outside the view start at their coarsest LOD. Visible children start at the coarsest LOD whose error does
/// not exceed the error of the replaced part, because a child's far LODs (Node::far_lods) may have larger
/// errors. If an LOD is lost, the next finer LOD replaces it. A part stays if its children cannot be loaded.
/// Node keys break ties between equal errors. Parts outside the view are not refined. The order of the
/// replacements matters only if a budget stops refinement. The first attempt therefore uses no priority
/// queue; if a budget stops it, a second attempt does.
class WantedCut {
 public:
  /// @param held  result of held() after the previous refinement; used only with hysteresis.
  WantedCut(const Hierarchy& hierarchy, double lattice_step, AttributeSet attributes, const View& view,
            const RefineOptions& options, std::span<const HeldNode> held);

  WantedNode& root() { return nodes_.front(); }
  std::span<WantedNode> nodes() { return nodes_; }
  /// Returns the children of an expanded node, by octant.
  std::span<WantedNode> children(const WantedNode& wanted) {
    return std::span(nodes_).subspan(wanted.first_child, wanted.node->knownChildren().size());
  }
  /// Returns a wanted node with its visibility and distance for this view.
  /// @param in_sight  true skips the visibility test; only for a node whose parent is wholly visible.
  WantedNode place(const KnownNode& node, bool in_sight = false) const;
  float errorPx(const WantedNode& wanted, uint32_t lod) const;
  const ViewFrustum& frustum() const noexcept { return frustum_; }

  bool limited() const noexcept { return limited_; }  ///< a budget stopped refinement too early
  bool blocked() const noexcept { return blocked_; }  ///< the page of some node's children is not loaded
  /// Returns true if lost blobs stopped refinement before all errors were within the threshold.
  bool stoppedByLoss() const noexcept { return stopped_by_loss_; }
  /// Returns the owners of the pages that the cut needs.
  const std::vector<NodeKey>& pages() const noexcept { return pages_; }
  std::vector<HeldNode> held() const;
  std::vector<WantedMesh> meshes() const;
  static uint32_t lastLod(const Node& node) { return static_cast<uint32_t>(node.lods.size()) - 1; }
  /// Returns the coarsest LOD that is not lost, or the last LOD if all are lost.
  static uint32_t coarsestLod(const KnownNode& node) { return node.coarsestLod().value_or(lastLod(node)); }

 private:
  /// A part to refine. The largest error comes first.
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
  /// Result of chooseCovers() for one subtree.
  struct Below {
    uint64_t bytes = 0;    // size of the wanted cut's payloads near the view
    bool settled = false;  // the subtree already has a covering step, or a page of the subtree is not loaded
  };

  void begin();
  void enqueue(uint32_t place);
  Candidate takeNext();
  void refine();
  bool wasFiner(const WantedNode& wanted) const;
  bool replacePart(const Candidate& candidate);
  bool expand(const Candidate& candidate, const Totals& totals);
  void skipWorse(WantedNode& wanted, float replaced_px) const;
  bool fits(const Candidate& candidate, const Totals& totals);
  void stopAt(const Candidate& candidate);
  Below chooseCovers(WantedNode& wanted);

  const Hierarchy& hierarchy_;
  const double step_;
  const AttributeSet attributes_;
  const ViewFrustum frustum_;
  const RefineOptions& options_;
  const std::span<const HeldNode> held_;
  std::vector<WantedNode> nodes_;
  bool is_best_first_ = false;
  std::vector<Candidate> open_;  // parts to refine; a heap if is_best_first_ is true
  Totals totals_;
  uint64_t page_bytes_ = 0;
  std::vector<NodeKey> pages_;
  bool stopped_ = false;  // refinement stopped at a budget
  bool limited_ = false, blocked_ = false, stopped_by_loss_ = false;
};

}  // namespace lode::core
