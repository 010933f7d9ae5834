#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/core/view.h"
#include "client/render/cluster_culling.h"
#include "client/render/depth_pyramid.h"
#include "client/render/gl_names.h"
#include "client/render/gpu_pages.h"

namespace lode::render {

/// The compute programs of GpuCulling. Made, used and destroyed on the thread of its context.
struct CullingPrograms {
  /// @throws Error kInternal if the driver rejects a shader.
  CullingPrograms();

  GlProgram find, list;
};

/// Has the GPU find which clusters of parts are drawn and write the commands that draw them: the processor
/// names the parts. In two passes over the same parts: first what the last frame's depth does not hide, then
/// what of the rest the depth of that does not hide. Commands come in the order of the parts, so that a
/// picture is drawn in the same order each time. Made, used and destroyed on the thread of its context.
/// Source: Aaltonen and Haar, GPU-Driven Rendering Pipelines, 2015 (two-pass occlusion culling).
class GpuCulling {
 public:
  /// What lies in one page and is drawn by one program.
  struct Draw {
    bool fades = false;
    uint32_t page = 0;
    uint32_t first_command = 0, most_commands = 0;
  };

  GpuCulling();
  ~GpuCulling();
  GpuCulling(GpuCulling&&) = delete;

  /// Of the current context: it counts draws on the GPU, and lets shaders read so large a page.
  static bool isPossible(uint64_t page_bytes = 0);

  /// The parts of a frame. @param lattice_step  of the model.
  void begin(std::span<const SeenPart> parts, double lattice_step);
  /// @param last  what the last frame's pyramid was built of, as the model saw it; nothing: all is drawn.
  void findUnhidden(const CullingPrograms& programs, const GpuPages& pages, const core::View& view,
                    const std::optional<core::View>& last, const DepthPyramid& last_drawn);
  void findAppeared(const CullingPrograms& programs, const GpuPages& pages, const core::View& view,
                    const DepthPyramid& drawn);

  /// For glMultiDrawElementsIndirectCount, after each pass: the draws, and where the pass begins in
  /// commands() and counts(), one of these for each draw.
  std::span<const Draw> draws() const noexcept { return draws_; }
  GLuint commands() const noexcept { return commands_.get(); }
  GLuint counts() const noexcept { return counts_.get(); }
  uint32_t firstCommandOfPass() const noexcept { return pass_ * most_commands_; }
  uint32_t firstCountOfPass() const noexcept { return pass_ * static_cast<uint32_t>(draws_.size()); }

  /// Of both passes of a frame some frames ago: nobody waits for the GPU.
  uint64_t trianglesLately() const noexcept;

 private:
  static constexpr uint32_t kFramesKept = 4;
  /// Clusters of one part, kChunkClusters at most, as the shaders read them.
  struct Chunk {
    uint32_t first_box_word, clusters, first_index, index_count;
    int32_t base_vertex;
    uint32_t state;
  };
  /// Of one draw, likewise.
  struct List {
    uint32_t first_chunk, chunks, first_command;
  };
  void addChunks(const SeenPart& part);
  void find(const CullingPrograms& programs, const GpuPages& pages, const core::View& view,
            const core::View* depth_view, const DepthPyramid& depths);

  double lattice_step_ = 1;
  std::vector<Chunk> chunks_;
  std::vector<List> lists_;
  std::vector<Draw> draws_;
  uint32_t most_commands_ = 0;  ///< of a pass
  uint32_t pass_ = 0;
  uint32_t frame_ = 0;
  GlBuffer chunks_buffer_, lists_buffer_, found_, commands_, counts_, triangles_;
  const uint32_t* triangles_told_ = nullptr;  ///< kFramesKept, mapped
};

}  // namespace lode::render
