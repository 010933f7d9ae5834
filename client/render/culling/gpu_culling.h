#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/culling/cluster_culling.h"
#include "client/render/culling/depth_pyramid.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/gl_names.h"
#include "client/render/residency/gpu_pages.h"

namespace lode::render {

/// Culls clusters on the GPU. The GPU also writes the draw commands; the CPU only lists the parts. Two passes
/// run over the same parts. The first pass finds the clusters that the depth of the last picture does not
/// hide. The second pass tests the remaining clusters against the depth of the clusters that the first pass
/// drew. A pass handles all models of a picture, so that the GPU synchronizes only twice. Commands keep the
/// order of the parts, so that pictures are deterministic. Create, use and destroy the object on the thread
/// of its OpenGL context. Source: Aaltonen and Haar, GPU-Driven Rendering Pipelines, 2015 (two-pass occlusion
/// culling).
class GpuCulling {
 public:
  /// One call of glMultiDrawElementsIndirectCount: clusters of one instance, one page and one program.
  struct Draw {
    uint32_t instance = 0;
    bool fades = false;
    uint32_t page = 0;
    /// Index of the first command, relative to firstCommandOfPass(), and largest number of commands.
    uint32_t first_command = 0, most_commands = 0;
    /// Index into counts() of the actual number of commands, relative to firstCountOfPass().
    uint32_t count = 0;
  };

  /// @param most_readable_bytes  size of the largest page that shaders read; the driver may set a smaller
  /// limit. Parts in larger pages are drawn without culling.
  /// @throws Error kInternal if the driver rejects a shader.
  explicit GpuCulling(uint64_t most_readable_bytes = std::numeric_limits<uint64_t>::max());
  ~GpuCulling();
  GpuCulling(GpuCulling&&) = delete;

  /// Returns true if the current context supports draw counts in GPU memory.
  static bool isPossible();

  /// Begins a picture. The pages and the items of all parts passed to add() must outlive the picture.
  void begin();
  /// Adds the parts of an instance.
  /// @param view       view in the instance's model frame.
  /// @param last_view  view of the instance in the last picture. Without a last view, the first pass treats
  /// no cluster as hidden.
  /// @return the instance's index in this picture.
  uint32_t add(std::span<const SeenPart> parts, const GpuPages& pages, double lattice_step,
               const core::View& view, const std::optional<core::View>& last_view);
  /// Runs the first pass. Call it once all instances are added.
  void findUnhidden();
  /// Runs the second pass. @param drawn  picture in which all clusters of the first pass are drawn.
  void findAppeared(const Framebuffer& drawn);

  /// Returns the draws of an instance; both passes use the same draws.
  std::span<const Draw> draws(uint32_t instance) const;
  GLuint commands() const noexcept { return commands_.get(); }
  GLuint counts() const noexcept { return counts_.get(); }
  uint32_t firstCommandOfPass() const noexcept { return pass_ * most_commands_; }
  uint32_t firstCountOfPass() const noexcept { return pass_ * static_cast<uint32_t>(lists_.size()); }

  /// Returns the number of triangles that the two passes drew in an earlier picture, three or more pictures
  /// ago. Does not block.
  uint64_t trianglesLately();

 private:
  static constexpr uint32_t kPicturesKept = 4;
  struct Listed {
    SeenPart part;
    const GpuPages* pages = nullptr;
    uint32_t instance = 0;
  };
  /// Camera of an instance in the layout of the shader.
  struct Camera {
    glm::ivec4 eye_high;  ///< high part of SplitEye; w is 1 if there are depths that can hide clusters
    glm::vec4 eye_low;    ///< low part of SplitEye
    /// View axes. The w components of the three vectors hold scale x, scale y and the near distance in
    /// lattice steps.
    glm::vec4 right, up, behind;
  };
  struct CameraPair {
    Camera now, before;
  };
  /// Up to kChunkClusters clusters of a part, in the layout of the shader.
  struct Chunk {
    uint32_t first_box_word, clusters, first_index, index_count;
    int32_t base_vertex;
    uint32_t state, instance;
  };
  /// Chunks that one Draw draws, in the layout of the shader.
  struct List {
    uint32_t first_chunk, chunks, first_command;
  };
  /// Chunks of one page that one dispatch of kFindShader tests.
  struct Group {
    GLuint page = 0;
    bool is_readable = true;
    uint32_t first_chunk = 0, chunks = 0;
  };

  void layOut();
  void addChunks(const SeenPart& part, uint32_t instance);
  void find(bool by_last_picture);

  GlProgram find_program_, list_program_;
  DepthPyramid depths_;
  uint64_t most_readable_bytes_;
  std::vector<Listed> listed_;
  std::vector<CameraPair> cameras_;  ///< cameras, indexed by instance
  std::vector<Chunk> chunks_;
  std::vector<Group> groups_;
  std::vector<List> lists_;
  std::vector<Draw> draws_;     ///< sorted by instance
  uint32_t most_commands_ = 0;  ///< largest number of commands per pass
  uint32_t pass_ = 0;
  uint32_t picture_ = 0;
  GlBuffer cameras_buffer_, chunks_buffer_, lists_buffer_, found_, commands_, counts_, triangles_;
  const uint32_t* mapped_triangles_ = nullptr;        ///< kPicturesKept triangle counters in mapped memory
  std::array<GLsync, kPicturesKept> count_fences_{};  ///< fences that signal when a counter is complete
  uint64_t triangles_lately_ = 0;
};

}  // namespace lode::render
