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
#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"
#include "client/render/residency/gpu_pages.h"

namespace lode::render {

/// Has the GPU find which clusters of a picture's parts are drawn and write the commands that draw them: the
/// processor names the parts. In two passes over the same parts: first what the last picture's depth does not
/// hide, then what of the rest the depth of that does not hide. Each pass is one for all models of a picture,
/// so that the GPU waits for itself but twice. Commands come in the order of the parts: a picture is drawn in
/// the same order each time. Made, used and destroyed on the thread of its context.
/// Source: Aaltonen and Haar, GPU-Driven Rendering Pipelines, 2015 (two-pass occlusion culling).
class GpuCulling {
 public:
  /// Of one instance what lies in one page and is drawn by one program, for
  /// glMultiDrawElementsIndirectCount.
  struct Draw {
    uint32_t instance = 0;
    bool fades = false;
    uint32_t page = 0;
    uint32_t first_command = 0, most_commands = 0;  ///< from where the pass begins in commands()
    uint32_t count = 0;                             ///< its place, from there in counts()
  };

  /// @param most_readable_bytes  of a page, beside what the driver lets shaders read: parts in larger ones
  /// are
  ///                             drawn whole.
  /// @throws Error kInternal if the driver rejects a shader.
  explicit GpuCulling(uint64_t most_readable_bytes = std::numeric_limits<uint64_t>::max());
  ~GpuCulling();
  GpuCulling(GpuCulling&&) = delete;

  /// Of the current context: it counts draws by itself.
  static bool isPossible();

  /// A picture begins. Pages and items of the parts that are added must outlive it.
  void begin();
  /// Parts of a model where it stands once, seen from there. @param last_view  of it in the last picture, in
  /// which nothing hid it where there is none. @return the instance's number in this picture.
  uint32_t add(std::span<const SeenPart> parts, const GpuPages& pages, double lattice_step,
               const core::View& view, const std::optional<core::View>& last_view);
  /// First pass, once all are added.
  void findUnhidden();
  /// Second pass. @param drawn  all that the first has found.
  void findAppeared(const Framebuffer& drawn);

  /// Of either pass.
  std::span<const Draw> draws(uint32_t instance) const;
  GLuint commands() const noexcept { return commands_.get(); }
  GLuint counts() const noexcept { return counts_.get(); }
  uint32_t firstCommandOfPass() const noexcept { return pass_ * most_commands_; }
  uint32_t firstCountOfPass() const noexcept { return pass_ * static_cast<uint32_t>(lists_.size()); }

  /// Of both passes, three pictures ago, or longer where the GPU is behind: nobody waits for it.
  uint64_t trianglesLately();

 private:
  static constexpr uint32_t kPicturesKept = 4;
  struct Listed {
    SeenPart part;
    const GpuPages* pages = nullptr;
    uint32_t instance = 0;
  };
  /// How a instance is seen in this picture and was in the last, as the shader reads it.
  struct Camera {
    glm::ivec4 eye_high;          ///< in steps of the model's lattice; and 1 if something hides
    glm::vec4 eye_low;            ///< likewise
    glm::vec4 right, up, behind;  ///< of the view, and scale x, scale y and, in steps, near
  };
  struct CameraPair {
    Camera now, before;
  };
  /// Clusters of one part, kChunkClusters at most, likewise.
  struct Chunk {
    uint32_t first_box_word, clusters, first_index, index_count;
    int32_t base_vertex;
    uint32_t state, instance;
  };
  /// Chunks that are drawn together, likewise.
  struct List {
    uint32_t first_chunk, chunks, first_command;
  };
  /// Chunks whose boxes are in one page.
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
  std::vector<CameraPair> cameras_;  ///< by instance
  std::vector<Chunk> chunks_;
  std::vector<Group> groups_;
  std::vector<List> lists_;
  std::vector<Draw> draws_;     ///< by instance
  uint32_t most_commands_ = 0;  ///< of a pass
  uint32_t pass_ = 0;
  uint32_t picture_ = 0;
  GlBuffer cameras_buffer_, chunks_buffer_, lists_buffer_, found_, commands_, counts_, triangles_;
  const uint32_t* triangles_told_ = nullptr;         ///< kPicturesKept, mapped
  std::array<GLsync, kPicturesKept> are_counted_{};  ///< signalled where they are complete
  uint64_t triangles_lately_ = 0;
};

}  // namespace lode::render
