#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/gl_names.h"
#include "client/render/passes/draw_style.h"
#include "client/render/residency/gpu_pages.h"
#include "client/render/residency/texture_residency.h"

namespace lode::render {

/// Shader programs that draw meshes, one per combination of features. Features are selected at compile time
/// instead of by branches, because a CPU renderer runs both sides of a branch for every pixel. Use the object
/// on the thread of its OpenGL context.
class MeshPrograms {
 public:
  enum Part : uint8_t {
    kFading = 1,    ///< draws a dithered share of the pixels
    kTextured = 2,  ///< samples textures
    kCutOut = 4,    ///< discards transparent pixels, for targets without multisampling
    kViews = 8,     ///< draws colour modes other than kSurface
    kWire = 16,     ///< draws triangle edges, with a geometry shader
    kSection = 32,  ///< removes the half beyond a section plane, and draws the cut surface
  };

  /// Links the program for kSurface without textures and fading, because linking delays the first picture.
  /// The others are linked when needed. @throws Error kInternal if the driver rejects a shader.
  MeshPrograms();

  /// Returns a program, and links it at the first use. @param parts  bits of Part.
  /// @throws the same errors as the constructor.
  const GlProgram& with(unsigned parts);

 private:
  std::array<GlProgram, 64> programs_;
};

/// State of one draw call in the layout of the shaders.
struct DrawState {
  uint32_t flags;
  glm::u8vec4 tint;
  uint32_t share;  ///< dither range in 256ths: FadedItem::from in the low and `to` in the high 16 bits
};

/// Sets up the OpenGL state for draw calls of a model's meshes. Between begin() and end(), call use(), then
/// bindPage() for each page, and draw indexed triangles. Pass the index of a DrawState as base instance.
/// Create, use and destroy the object on the thread of its OpenGL context.
class MeshDrawer {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  MeshDrawer();

  /// Sets the state for draw calls.
  /// @param states      buffer with an array of DrawState.
  /// @param attributes  the attributes of all meshes of the model.
  void begin(const GlBuffer& states, AttributeSet attributes, const TextureResidency& textures);
  /// Selects a program. @param has_samples  true if the target is multisampled.
  void use(bool fades, bool has_samples, const core::View& view, double lattice_step, const DrawStyle& style);
  void bindPage(const GpuPages& pages, uint32_t page) const;
  void end() const;

 private:
  void setCamera(const core::View& view, double lattice_step, const DrawStyle& style) const;
  void setTextures() const;

  MeshPrograms programs_;
  bool has_begun_ = false;  ///< begin() was called
  GlVertexArray array_;
  AttributeSet attributes_;
  const TextureResidency* textures_ = nullptr;  ///< textures passed to begin()
};

/// Sets all OpenGL state on which drawing relies.
void setFrameState();
/// Binds a target, sets the frame state, and clears the depth unless style.over is set.
void startPicture(const Framebuffer& target, const DrawStyle& style);
/// Binds a target and sets the frame state, to continue its picture.
void continuePicture(const Framebuffer& target);

}  // namespace lode::render
