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
#include "client/render/gl/framebuffer.h"
#include "client/render/instance_drawer.h"
#include "client/render/passes/color_mode.h"
#include "client/render/passes/cross_fade.h"
#include "client/render/passes/draw_style.h"
#include "client/render/passes/mesh_drawer.h"
#include "client/render/residency/mesh_residency.h"
#include "client/render/residency/texture_residency.h"

namespace lode::render {

/// Draws the cuts (core::Cut) of one model, as one instance or several. Create, use and destroy the object on
/// the thread of its OpenGL 4.5 context. The renderer relies on no OpenGL state, but changes the bound
/// framebuffer, program and vertex array, and the depth and polygon state.
class Renderer {
 public:
  /// @param lattice_step  the model's lattice step, see isLatticeStep().
  /// @throws Error kIo if the driver is out of memory, kInternal if it rejects a shader.
  explicit Renderer(double lattice_step = 1, const ResidencyOptions& options = {});

  /// Sets the lattice step if the model was unknown at construction. Call setLatticeStep() before the first
  /// show().
  void setLatticeStep(double lattice_step) noexcept { lattice_step_ = lattice_step; }

  /// Sets the newest cut of a model with one instance.
  void show(const std::shared_ptr<const core::Cut>& cut);
  /// Sets the newest cuts of a model with several instances.
  void show(std::shared_ptr<const core::ViewCuts> view_cuts);
  /// Frees the GPU memory of meshes and textures. Draws nothing until the next show().
  void release();
  /// Uploads meshes, then textures, of the newest cuts within the budget. @return the rest of the budget.
  UploadBudget uploadInRenderThread(const UploadBudget& budget);
  /// Returns true if the newest cuts are drawn with all of their textures.
  bool upToDate() const noexcept { return meshes_.upToDate() && textures_.upToDate(); }

  /// Changes the memory budgets. The staging buffers keep their size.
  void setMemory(const ResidencyOptions& options);

  /// Returns the residency, which keeps the meshes on the GPU and decides which cut is drawn.
  MeshResidency& meshes() noexcept { return meshes_; }
  const MeshResidency& meshes() const noexcept { return meshes_; }
  const TextureResidency& textures() const noexcept { return textures_; }
  /// Returns the parts of an instance that the last picture shows.
  std::span<const DrawItem> inPicture(size_t instance = 0) const noexcept {
    return instance < instances_.size() ? std::span<const DrawItem>(instances_[instance].in_picture)
                                        : std::span<const DrawItem>();
  }
  /// Returns the GPU memory of meshes, tiles and staging buffers.
  uint64_t gpuBytes() const noexcept;

  /// Draws the model, and the background unless style.over is set. The view must have the target's size.
  DrawCounts draw(const core::View& view, const Framebuffer& target, const DrawStyle& style = {},
                  const DrawTime& time = {});
  /// Draws one instance without background. With OcclusionCulling::kReadBack, draws only the clusters that
  /// were not hidden in the last frame; drawAppeared() then tests the other clusters and draws those that
  /// have become visible.
  /// @param view  view in the instance's model frame.
  DrawCounts drawInstance(size_t instance, const core::View& view, const Framebuffer& target,
                          const DrawStyle& style, const DrawTime& time);
  /// Returns the number of clusters of the instance that drawInstance() found in the view.
  size_t clustersInPicture(size_t instance) const noexcept { return instances_[instance].seen.size(); }
  /// Draws the clusters that drawInstance() skipped, except those that the drawn depth hides. The picture is
  /// then the same as without culling. @param drawn  depth after drawInstance() was called for all instances.
  DrawCounts drawAppeared(size_t instance, const core::View& view, const Framebuffer& target,
                          const DrawStyle& style, const FarthestDepths& drawn);
  /// Adds an instance's parts in the view to `culling`, for OcclusionCulling::kOnGpu. The returned counts
  /// have no triangles; see GpuCulling::trianglesLately().
  DrawCounts addInstance(size_t instance, const core::View& view, const DrawStyle& style,
                         const DrawTime& time, GpuCulling& culling);
  /// Draws the clusters of an instance that the last culling pass found. Call continuePicture() first.
  /// @return number of draw calls.
  uint32_t drawFound(size_t instance, const core::View& view, const Framebuffer& target,
                     const DrawStyle& style, const GpuCulling& culling);
  /// Fills the pixels that no model covers. Call drawBackground() last.
  void drawBackground(const Framebuffer& target, const DrawStyle& style) const;
  /// Forgets an instance that is not drawn in this frame. When it is drawn again, it appears without fading
  /// in.
  void leaveOut(size_t instance);
  /// Returns true while a cross-fade runs. The next frame then differs from the last frame.
  bool fading() const noexcept;
  /// Returns true while the last picture has parts no older than kOldS. ColorMode::kAges still changes their
  /// colours.
  bool ageing() const noexcept;

 private:
  /// State of one instance.
  struct DrawnInstance {
    CrossFade fade;
    /// Serial of the cut in the last picture; 0 if the instance was not drawn.
    uint64_t shown_serial = 0;
    std::vector<SeenCluster> seen;  ///< clusters in the view; unused with culling on the GPU
    /// One flag per element of `seen`: true if drawInstance() drew the cluster. A cluster of a mesh that
    /// fades in and out at the same time is in `seen` twice.
    std::vector<bool> is_drawn;
    std::vector<SeenPart> parts;          ///< parts in the view, for culling on the GPU
    uint32_t number = 0;                  ///< index that GpuCulling::add() returned
    std::optional<core::View> last_view;  ///< view of the last picture, for culling on the GPU
    std::vector<DrawItem> in_picture;     ///< parts of the cut, without parts that fade out
    std::vector<DrawState> states;        ///< states of parts of the cut, then of parts that fade out
    size_t states_of_cut = 0;
    GlBuffer states_buffer;
  };
  void showTextures();
  void keepShownMeshes();
  DrawState stateOf(const FadedItem& faded, const DrawStyle& style, float threshold_rad) const;
  DrawnInstance& choose(size_t number, const core::View& view, const DrawTime& time);
  DrawCounts collect(DrawnInstance& instance, const core::View& view, const DrawStyle& style,
                     bool is_found_on_gpu);
  static void countShown(const DrawnInstance& instance, const SeenPart& part, uint32_t triangles,
                         const core::View& view, DrawCounts& counts);
  void drawClusters(const DrawnInstance& instance, const std::vector<bool>& is_chosen, const core::View& view,
                    const DrawStyle& style, DrawCounts& counts);
  void uploadCommands();
  uint32_t drawList(const DrawList& list) const;

  double lattice_step_;
  MeshResidency meshes_;
  TextureResidency textures_;
  std::vector<DrawnInstance> instances_;
  bool fades_ = false;       ///< DrawTime::fades of the last picture
  bool has_samples_ = true;  ///< true if the target is multisampled
  MeshDrawer drawer_;
  GlProgram background_program_;
  GlVertexArray empty_array_;
  GlBuffer commands_buffer_;
  DrawList whole_, fading_;
  InstanceDrawer instance_drawer_;  ///< drawer that draw() uses
};

}  // namespace lode::render
