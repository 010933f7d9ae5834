#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "client/render/gl/framebuffer.h"
#include "client/render/renderer.h"

namespace lode::test {

/// Counts background pixels inside a model while its cuts cross-fade. A pixel is inside if it and its
/// neighbours are covered by every cut that was drawn for this camera within the last duration of a fade.
class BackgroundWatch {
 public:
  struct Counter {
    uint64_t frames = 0, fading_frames = 0;
    uint64_t mixed_frames = 0;  ///< frames that drew a mixture of two cuts
    uint64_t inside = 0;        ///< number of pixels inside the model, over all frames
    uint64_t background = 0;    ///< number of these pixels that show background

    bool operator==(const Counter&) const = default;
  };

  /// @param upload_bytes  upload budget of one frame; by default, a cut is uploaded at once.
  BackgroundWatch(double lattice_step, uint32_t width_px, uint32_t height_px,
                  std::optional<uint32_t> upload_bytes = std::nullopt)
      : fading_(lattice_step),
        alone_(lattice_step),
        target_(width_px, height_px, 1),
        upload_(upload_bytes ? render::UploadBudget{.bytes = *upload_bytes, .ms = 1000}
                             : render::UploadBudget{.wait = true}) {}

  /// Draws one frame with a cut. The camera may change only if uploaded() is true.
  void frame(const std::shared_ptr<const core::Cut>& cut, const core::View& view, double now_s) {
    if (covered_.empty() || view != view_) {
      view_ = view;
      covered_.clear();
      if (alone_.meshes().drawnCut()) cover(now_s);
    }
    const bool is_same = !covered_.empty() && alone_.meshes().drawnCut() == cut;
    uploadAlone(cut);
    fading_.show(cut);
    do fading_.uploadInRenderThread(upload_);
    while ((upload_.wait && !uploaded()) || !fading_.meshes().drawnCut());
    if (!is_same) cover(now_s);
    covered_.back().now_s = now_s;
    if (!uploaded())  // each of the cuts may still be drawn somewhere
      for (Covered& covered : covered_) covered.now_s = now_s;
    const auto isDrawn = [&](const Covered& covered) { return covered.cut == fading_.meshes().drawnCut(); };
    if (std::ranges::none_of(covered_, isDrawn)) ++counts_.mixed_frames;
    while (covered_.front().now_s < now_s - render::kFadeS) covered_.pop_front();
    fading_.draw(view, target_, style_, {now_s, true});
    count(pixelsOfModel());
  }
  /// Returns the pixels that a cut covers if it is drawn alone.
  std::vector<bool> coveredBy(const std::shared_ptr<const core::Cut>& cut, const core::View& view) {
    uploadAlone(cut);
    alone_.draw(view, target_, style_);
    return pixelsOfModel();
  }
  const Counter& counts() const noexcept { return counts_; }
  bool fading() const noexcept { return fading_.fading(); }
  /// Returns true if the last frame's cut is completely resident.
  bool uploaded() const noexcept { return fading_.upToDate(); }

 private:
  struct Covered {
    std::shared_ptr<const core::Cut> cut;
    double now_s;
    std::vector<bool> pixels;
  };

  static render::DrawStyle magenta() {
    render::DrawStyle style;
    style.background_top_srgb = style.background_bottom_srgb = glm::vec3(1, 0, 1);
    return style;
  }

  std::vector<bool> pixelsOfModel() const {
    target_.resolve();
    const render::Image image = target_.readPixels();
    std::vector<bool> pixels(size_t{image.width_px} * image.height_px);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const uint8_t* const p = &image.rgba[4 * i];
      pixels[i] = !(p[0] == 255 && p[1] == 0 && p[2] == 255);
    }
    return pixels;
  }
  void uploadAlone(const std::shared_ptr<const core::Cut>& cut) {
    alone_.show(cut);
    while (!alone_.upToDate()) alone_.uploadInRenderThread({.wait = true});
  }
  void cover(double now_s) {
    alone_.draw(view_, target_, style_);
    covered_.push_back({alone_.meshes().drawnCut(), now_s, pixelsOfModel()});
  }
  void count(const std::vector<bool>& drawn) {
    ++counts_.frames;
    if (fading_.fading()) ++counts_.fading_frames;
    for (uint32_t y = 1; y + 1 < view_.height_px; ++y) {
      for (uint32_t x = 1; x + 1 < view_.width_px; ++x) {
        if (!isInside(x, y)) continue;
        ++counts_.inside;
        if (!drawn[size_t{y} * view_.width_px + x]) ++counts_.background;
      }
    }
  }
  /// Returns true if all cuts cover the pixel and its neighbours. The neighbours count because outlines of
  /// cuts differ.
  bool isInside(uint32_t x, uint32_t y) const {
    for (const Covered& covered : covered_) {
      for (uint32_t row = y - 1; row <= y + 1; ++row) {
        for (uint32_t column = x - 1; column <= x + 1; ++column)
          if (!covered.pixels[size_t{row} * view_.width_px + column]) return false;
      }
    }
    return true;
  }

  render::Renderer fading_, alone_;
  const render::Framebuffer target_;
  const render::UploadBudget upload_;
  const render::DrawStyle style_ = magenta();
  core::View view_;
  std::deque<Covered> covered_;
  Counter counts_;
};

}  // namespace lode::test
