#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/draw_style.h"
#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"
#include "client/render/passes/mesh_programs.h"
#include "client/render/residency/gpu_pages.h"
#include "client/render/residency/texture_residency.h"

namespace lode::render {

/// What all triangles of a draw share, as the shaders read it.
struct DrawState {
  uint32_t flags;
  glm::u8vec4 tint;
  uint32_t share;  ///< of the pixels: from and to in 256ths, 16 bits each
};

/// What the draw calls of a model's meshes have in common. Between begin() and end(): use() a program, and
/// for each page bindPage() and draw indexed triangles whose base instance is the number of a state. Made,
/// used and destroyed on the thread of its context.
class MeshDrawer {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  MeshDrawer();

  /// @param states      of DrawState, one after the other.
  /// @param attributes  the model's, of all meshes.
  void begin(const GlBuffer& states, AttributeSet attributes, const TextureResidency& textures);
  /// @param has_samples  of a pixel, the target.
  void use(bool fades, bool has_samples, const core::View& view, double lattice_step, const DrawStyle& style);
  void bindPage(const GpuPages& pages, uint32_t page) const;
  void end() const;

 private:
  void setCamera(const core::View& view, double lattice_step, const DrawStyle& style) const;
  void setTextures() const;

  MeshPrograms programs_;
  GlVertexArray array_;
  AttributeSet attributes_;
  const TextureResidency* textures_ = nullptr;  ///< between begin() and end()
};

/// What drawing starts from, whatever was drawn before.
void setFrameState();
/// The same for a picture, whose depth is cleared unless it is drawn over what is there.
void startPicture(const Framebuffer& target, const DrawStyle& style);
/// The same for one that goes on.
void goOnWithPicture(const Framebuffer& target);

}  // namespace lode::render
