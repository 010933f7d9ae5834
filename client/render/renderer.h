#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/cut.h"
#include "client/core/placed_cuts.h"
#include "client/core/view.h"
#include "client/render/cluster_culling.h"
#include "client/render/cross_fade.h"
#include "client/render/depth_reader.h"
#include "client/render/draw_list.h"
#include "client/render/framebuffer.h"
#include "client/render/mesh_programs.h"
#include "client/render/mesh_residency.h"
#include "client/render/shown_colours.h"
#include "client/render/shown_thresholds.h"
#include "client/render/texture_residency.h"

namespace lode::render {

struct DrawStyle {
  Show show = Show::kSurface;
  glm::dvec3 up{0};                                    ///< of the model, where its sky is; 0: as the view
  ShownPlace place = {};                               ///< of the model, among others
  float exposure = 1;                                  ///< by which the light is multiplied, > 0
  glm::vec3 background_top_srgb{0.30f, 0.34f, 0.39f};  ///< 0..1
  glm::vec3 background_bottom_srgb{0.10f, 0.11f, 0.13f};
  bool over = false;  ///< what the target has stays and hides what is behind it; no background is drawn

  bool operator==(const DrawStyle&) const = default;
};

struct DrawCounts {
  uint64_t triangles = 0;  ///< sent to the GPU, after culling
  uint32_t nodes = 0;
  uint32_t calls = 0;
  float error_px = 0;  ///< largest in the picture, from where the cut was made for
  ShownThresholds shown;

  DrawCounts& operator+=(const DrawCounts& more) noexcept;
};

/// Draws the cuts of one model where it stands, in one place or several. Made, used and destroyed on the
/// thread of its OpenGL 4.5 context. Needs nothing of the context's state and leaves behind: bound
/// framebuffer, program, vertex array, depth and polygon state.
class Renderer {
 public:
  /// @param lattice_step  of the model, see isLatticeStep().
  /// @throws Error kIo or kInternal if the driver lacks memory or rejects a shader.
  explicit Renderer(double lattice_step = 1, const ResidencyOptions& options = {});

  /// For a model that becomes known later; before its first cut is shown.
  void setLatticeStep(double lattice_step) noexcept { lattice_step_ = lattice_step; }

  /// The newest cut of a model that stands in one place, its meshes and its textures.
  void show(const std::shared_ptr<const core::Cut>& cut);
  /// The newest cuts of one that stands in several.
  void show(std::shared_ptr<const core::PlacedCuts> placed);
  /// Uploads towards them, meshes first, within the budget. @return what is left of that.
  UploadBudget uploadInRenderThread(const UploadBudget& budget);
  /// The newest cuts are those drawn, with all of their textures.
  bool upToDate() const noexcept { return meshes_.upToDate() && textures_.upToDate(); }

  /// Other budgets than at the start; what it uploads through stays as large as it is.
  void setMemory(const ResidencyOptions& options);

  /// Decides what is drawn; see MeshResidency.
  MeshResidency& meshes() noexcept { return meshes_; }
  const MeshResidency& meshes() const noexcept { return meshes_; }
  const TextureResidency& textures() const noexcept { return textures_; }
  /// What the last picture was made of.
  std::span<const DrawItem> inPicture() const noexcept { return in_picture_; }
  /// Of the copies of meshes and tiles, and what uploads go through.
  uint64_t gpuBytes() const noexcept;

  /// Draws background and model. view.width_px and height_px are those of the target.
  DrawCounts draw(const core::View& view, const Framebuffer& target, const DrawStyle& style = {},
                  const DrawTime& time = {});
  /// Draws the model at one of its places, and no background. Where what is hidden is left out, only what was
  /// not hidden in the last frame: drawAppeared() gives the rest. @param view  as the model sees it from
  /// there.
  DrawCounts drawPlace(size_t place, const core::View& view, const Framebuffer& target,
                       const DrawStyle& style, const DrawTime& time);
  /// Draws what drawPlace() has left out and what is drawn does not hide. The same samples get the same
  /// colours as if all were drawn. @param drawn  of all that drawPlace() has drawn at any place.
  DrawCounts drawAppeared(size_t place, const core::View& view, const Framebuffer& target,
                          const DrawStyle& style, const FarthestDepths& drawn);
  /// Where nothing was drawn: last, so that little of it has to be.
  void drawBackground(const Framebuffer& target, const DrawStyle& style) const;
  /// Nothing is drawn at this place now: when it is next, all appears at once.
  void leaveOut(size_t place);
  /// The next frame differs from the last, although nothing else has changed.
  bool fading() const noexcept;
  /// Something in the last picture is not old yet: colours by age still change.
  bool ageing() const noexcept;

 private:
  /// What all triangles of a draw share, as the shaders read it.
  struct DrawState {
    uint32_t flags;
    glm::u8vec4 tint;
    uint32_t share;  ///< of the pixels: from and to in 256ths, 16 bits each
  };
  /// What is in the picture where the model stands once.
  struct Place {
    CrossFade fade;
    uint64_t shown_serial = 0;      ///< of the cuts in the last picture; 0: it was not in it
    std::vector<SeenCluster> seen;  ///< that may be in the picture
    std::vector<bool> is_drawn;     ///< by seen: apart, as one that leaves and has come back is there twice
    std::vector<DrawState> states;  ///< by base_instance: of the cut, then
    size_t states_of_cut = 0;       ///< of what leaves
  };
  void showTextures();
  void keepWhatIsShown();
  DrawState stateOf(const FadedItem& faded, const DrawStyle& style, float threshold_rad) const;
  void choose(Place& place, size_t number, const core::View& view, const DrawTime& time);
  DrawCounts collect(Place& place, const core::View& view, const DrawStyle& style, float threshold_rad);
  void drawClusters(const Place& place, const std::vector<bool>& is_chosen, const core::View& view,
                    const DrawStyle& style, DrawCounts& counts);
  void setCamera(const core::View& view, const DrawStyle& style) const;
  void setTextures() const;
  void bindDraws(const Place& place);
  const GlProgram& program(bool fades, const DrawStyle& style);
  uint32_t drawList(const DrawList& list, AttributeSet attributes) const;

  double lattice_step_;
  MeshResidency meshes_;
  TextureResidency textures_;
  std::vector<Place> places_;
  bool fades_ = false;       ///< the last picture did
  bool has_samples_ = true;  ///< the target
  MeshPrograms programs_;
  GlProgram background_program_;
  GlVertexArray mesh_array_, empty_array_;
  GlBuffer commands_buffer_, states_buffer_;
  DrawList whole_, fading_;
  DepthReader depth_reader_;
  std::vector<DrawItem> in_picture_;  ///< of the cut alone, where it was drawn last
};

}  // namespace lode::render
