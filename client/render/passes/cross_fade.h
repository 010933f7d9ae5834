#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"
#include "client/render/culling/hidden_parts.h"
#include "client/render/residency/changed_regions.h"
#include "client/render/residency/mesh_residency.h"

namespace lode::render {

constexpr double kFadeS = 0.25;
constexpr float kLargestFadedStepPx =
    4;  ///< what moves further would show the background: it switches at once

/// When a frame is drawn.
struct DrawTime {
  double now_s = 0;    ///< of any clock that does not go back
  bool fades = false;  ///< what has changed since the last frame takes its place by a cross-fade
  HiddenParts hidden_parts = HiddenParts::kDrawn;
};

/// A part of the picture, drawn on those pixels whose dither value, 0..1, lies in [from, to). Where parts
/// cover the same place, theirs add up to [0, 1) and do not overlap: each pixel shows one surface.
struct FadedItem {
  DrawItem item;
  float from = 0, to = 1;

  bool whole() const noexcept { return from <= 0 && to >= 1; }
};

/// What one frame shows.
struct ShownCover {
  std::shared_ptr<const core::Cut> cut;
  std::span<const DrawItem> drawn;    ///< of the cut, by the numbers of core::partOf()
  std::span<const uint32_t> numbers;  ///< of them, what covers the model
  uint64_t serial = 0;                ///< of the cut; a newer one's is larger
};

/// Lets what arrives in a picture take the place of what leaves it pixel by pixel, each region by its own
/// clock. Nothing fades where one of both sides does not cover what the camera sees, or where the step is
/// large. Needs no OpenGL.
class CrossFade {
 public:
  /// Compares with what the last frame showed. What leaves is drawn from its place on the GPU.
  /// @param fades  false: the cover is shown at once, and fades under way end.
  void show(const ShownCover& cover, const core::View& view, double lattice_step, const DrawTime& time);
  /// Something that was shown has lost its place: nothing fades from it.
  void forget();

  /// Of the last show(); null: none.
  const std::shared_ptr<const core::Cut>& cut() const noexcept { return cut_; }
  /// The cover's items and those that leave, with their shares at the time of the last show().
  const std::vector<FadedItem>& items() const noexcept { return items_; }
  /// How many of items() are the cover's; they come first.
  size_t coverCount() const noexcept { return live_.size(); }
  bool fading() const noexcept { return !leaving_.empty(); }
  /// The oldest cut whose meshes are still drawn.
  uint64_t oldestSerial() const noexcept;

 private:
  static constexpr double kEver = -std::numeric_limits<double>::infinity();

  struct Part {
    DrawItem item;
    const Mesh* mesh = nullptr;  ///< not looked into
    double since_s = 0;          ///< it is shown; and where it fades
    double arrived_s = kEver, left_s = 0;
    uint64_t serial = 0;  ///< of the last cut that had it
  };
  /// A place that one side of a fade does not cover.
  struct Gap {
    NodeKey region;
    core::ModelBox box;
    double until_s = 0;
  };

  struct Change {
    std::shared_ptr<const core::Cut> cut_before;
    std::vector<Part> before;
    std::vector<ChangedRegion> regions;  ///< of before and live_
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
  bool lost_ = false;
  std::vector<FadedItem> items_;
};

}  // namespace lode::render
