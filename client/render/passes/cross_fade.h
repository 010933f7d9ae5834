#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"
#include "client/render/passes/draw_style.h"
#include "client/render/residency/changed_regions.h"
#include "client/render/residency/mesh_residency.h"

namespace lode::render {

/// Duration of a cross-fade in seconds.
constexpr double kFadeS = 0.25;
/// Largest error of parts that cross-fade, in pixels. Parts with a larger error switch at once, because the
/// background would show through between two dithered surfaces that are far apart.
constexpr float kLargestFadedStepPx = 4;

/// A part that is drawn only on pixels whose dither value (0..1) lies in [from, to). The ranges of all parts
/// that cover the same region add up to [0, 1) without overlap, so that each pixel shows exactly one surface.
struct FadedItem {
  DrawItem item;
  float from = 0, to = 1;

  bool whole() const noexcept { return from <= 0 && to >= 1; }
};

/// The parts that one frame shows: a cut, and a choice of its parts and fallbacks.
struct ShownCover {
  std::shared_ptr<const core::Cut> cut;
  std::span<const DrawItem> drawn;    ///< items of the cut, indexed as in core::partOf()
  std::span<const uint32_t> numbers;  ///< indices of the items that together cover the model
  uint64_t serial = 0;                ///< serial of the cut; newer cuts have larger serials
};

/// Cross-fades from leaving to arriving parts by dithering. Each region starts its fade at its own time. A
/// region switches at once if its error is large, or if its leaving or its arriving parts do not cover
/// everything that the camera sees of the region. Uses no OpenGL.
class CrossFade {
 public:
  /// Shows a cover and starts fades from the parts of the last frame, whose meshes must still be resident.
  /// If time.fades is false, shows the cover at once and ends running fades.
  void show(const ShownCover& cover, const core::View& view, double lattice_step, const DrawTime& time);
  /// Ends all fades. The next show() starts no fade. Call forget() after a mesh of the last frame was
  /// evicted.
  void forget();

  /// Returns the cut of the last show(), or null if there is none.
  const std::shared_ptr<const core::Cut>& cut() const noexcept { return cut_; }
  /// Returns the cover's items, then the leaving items, with their dither ranges as of the last show().
  const std::vector<FadedItem>& items() const noexcept { return items_; }
  /// Returns the number of items() that belong to the cover.
  size_t coverCount() const noexcept { return live_.size(); }
  bool fading() const noexcept { return !leaving_.empty(); }
  /// Returns the smallest serial of a part that fades out, or the largest uint64_t if no part fades out. The
  /// serial of a part is that of the last cut that contained the part.
  uint64_t oldestSerial() const noexcept;

 private:
  static constexpr double kLongAgo = -std::numeric_limits<double>::infinity();

  struct Part {
    DrawItem item;
    const Mesh* mesh = nullptr;               ///< address that identifies the mesh; not dereferenced
    double since_s = 0;                       ///< time when the part was first shown
    double arrived_s = kLongAgo, left_s = 0;  ///< start times of fading in and fading out
    uint64_t serial = 0;                      ///< serial of the last cut with this part
  };
  /// A box that either the leaving or the arriving parts of a fade do not cover.
  struct Gap {
    NodeKey region;
    core::ModelBox box;
    double until_s = 0;
  };

  struct Change {
    std::shared_ptr<const core::Cut> cut_before;
    std::vector<Part> before;
    std::vector<ChangedRegion> regions;  ///< regions with indices into before and live_
  };

  Change take(const ShownCover& cover, double now_s);
  void change(const ShownCover& cover, const core::ViewFrustum& frustum, double lattice_step, double now_s);
  bool mayFade(const Change& change, const ChangedRegion& region, const core::ViewFrustum& frustum,
               double lattice_step) const;
  void noteGaps(const Change& change, std::span<const ChangedRegion* const> regions, double until_s);
  static std::vector<Part> partsOf(const ShownCover& cover, double now_s);
  std::vector<NodeKey> endFadesAt(std::span<const NodeKey> nodes);
  void endFadesInSight(const core::ViewFrustum& frustum, double now_s);
  void list(double now_s);

  std::shared_ptr<const core::Cut> cut_;
  std::vector<uint32_t> numbers_;
  std::vector<Part> live_, leaving_;
  std::vector<Gap> gaps_;
  bool is_forgotten_ = false;  ///< true if forget() was called since the last show()
  std::vector<FadedItem> items_;
};

}  // namespace lode::render
