#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"
#include "client/render/culling/cluster_culling.h"
#include "client/render/culling/occluders.h"
#include "client/render/draw_counts.h"
#include "client/render/draw_list.h"
#include "client/render/draw_style.h"
#include "client/render/framebuffer.h"
#include "client/render/instance_drawer.h"
#include "client/render/passes/cross_fade.h"
#include "client/render/passes/mesh_drawer.h"
#include "client/render/residency/mesh_residency.h"
#include "client/render/residency/texture_residency.h"
#include "client/render/shown_colours.h"

namespace lode::render {

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
  void show(std::shared_ptr<const core::ViewCuts> view_cuts);
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
  /// What the last picture was made of at a place.
  std::span<const DrawItem> inPicture(size_t instance = 0) const noexcept {
    return instance < instances_.size() ? std::span<const DrawItem>(instances_[instance].in_picture)
                                        : std::span<const DrawItem>();
  }
  /// Of the copies of meshes and tiles, and what uploads go through.
  uint64_t gpuBytes() const noexcept;

  /// Draws background and model. view.width_px and height_px are those of the target.
  DrawCounts draw(const core::View& view, const Framebuffer& target, const DrawStyle& style = {},
                  const DrawTime& time = {});
  /// Draws the model at one of its places, and no background. Where what is hidden is left out, only what was
  /// not hidden in the last frame: drawAppeared() gives the rest.
  /// @param view  as the model sees it from there.
  DrawCounts drawInstance(size_t instance, const core::View& view, const Framebuffer& target,
                          const DrawStyle& style, const DrawTime& time);
  /// That drawInstance() has found in the picture there.
  size_t clustersInPicture(size_t instance) const noexcept { return instances_[instance].seen.size(); }
  /// Draws what drawInstance() has left out and what is drawn does not hide. The same samples get the same
  /// colours as if all were drawn. @param drawn  of all that drawInstance() has drawn at any place.
  DrawCounts drawAppeared(size_t instance, const core::View& view, const Framebuffer& target,
                          const DrawStyle& style, const FarthestDepths& drawn);
  /// Where the GPU finds what is hidden: adds what may be drawn at a place. Its triangles are not counted:
  /// see GpuCulling::trianglesLately().
  DrawCounts addInstance(size_t instance, const core::View& view, const DrawStyle& style,
                         const DrawTime& time, GpuCulling& culling);
  /// Draws of that what the last pass has found, after goOnWithPicture(). @return draw calls.
  uint32_t drawFound(size_t instance, const core::View& view, const Framebuffer& target,
                     const DrawStyle& style, const GpuCulling& culling);
  /// Where nothing was drawn: last, so that little of it has to be.
  void drawBackground(const Framebuffer& target, const DrawStyle& style) const;
  /// Nothing is drawn at this place now: when it is next, all appears at once.
  void leaveOut(size_t instance);
  /// The next frame differs from the last, although nothing else has changed.
  bool fading() const noexcept;
  /// Something in the last picture is not old yet: colours by age still change.
  bool ageing() const noexcept;

 private:
  /// What is in the picture where the model stands once.
  struct DrawnInstance {
    CrossFade fade;
    uint64_t shown_serial = 0;      ///< of the cuts in the last picture; 0: it was not in it
    std::vector<SeenCluster> seen;  ///< what may be in the picture, unless the GPU finds clusters
    std::vector<bool> is_drawn;     ///< by seen: apart, as one that leaves and has come back is there twice
    std::vector<SeenPart> parts;    ///< what may be in the picture, where the GPU finds their clusters
    uint32_t number = 0;            ///< the instance's, in the GPU's picture
    std::optional<core::View> last_view;  ///< in the last picture, where the GPU has found what to draw
    std::vector<DrawItem> in_picture;     ///< of the cut alone
    std::vector<DrawState> states;        ///< by base_instance: of the cut, then of what leaves
    size_t states_of_cut = 0;
    GlBuffer states_buffer;
  };
  void showTextures();
  void keepWhatIsShown();
  DrawState stateOf(const FadedItem& faded, const DrawStyle& style, float threshold_rad) const;
  DrawnInstance& choose(size_t number, const core::View& view, const DrawTime& time);
  DrawCounts collect(DrawnInstance& instance, const core::View& view, const DrawStyle& style,
                     bool is_found_on_gpu);
  static void countShown(const DrawnInstance& instance, const SeenPart& part, uint32_t triangles,
                         const core::View& view, DrawCounts& counts);
  void drawClusters(const DrawnInstance& instance, const std::vector<bool>& is_chosen, const core::View& view,
                    const DrawStyle& style, DrawCounts& counts);
  void giveCommands();
  uint32_t drawList(const DrawList& list) const;

  double lattice_step_;
  MeshResidency meshes_;
  TextureResidency textures_;
  std::vector<DrawnInstance> instances_;
  bool fades_ = false;       ///< the last picture did
  bool has_samples_ = true;  ///< the target
  MeshDrawer drawer_;
  GlProgram background_program_;
  GlVertexArray empty_array_;
  GlBuffer commands_buffer_;
  DrawList whole_, fading_;
  InstanceDrawer instance_drawer_;  ///< of draw()
};

}  // namespace lode::render
