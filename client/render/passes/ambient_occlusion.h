#pragma once

#include <cstdint>

#include "client/render/gl/framebuffer.h"
#include "client/render/gl/gl_names.h"
#include "client/render/passes/color_mode.h"

namespace lode::render {

/// Screen-space ambient occlusion. Darkens the creases and hollows that the depth of a drawn picture shows.
/// The radius is relative to the picture's height, so that a model looks the same near and far. The result
/// depends on the depth alone: equal depths give equal bits. Create, use and destroy the object on the thread
/// of its OpenGL context. Source: McGuire, Mara and Luebke, Scalable Ambient Obscurance, 2012.
class AmbientOcclusion {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  AmbientOcclusion();

  /// Darkens a picture. Call darken() once, after drawing all models and before resolving the picture. Skips
  /// background samples. Does nothing unless `show` is kSurface, because colours stand for values in the
  /// other modes. Changes the bound framebuffer, program, vertex array and textures, and the depth state.
  /// @param picture  multisampled framebuffer with the drawn models.
  void darken(const Framebuffer& picture, double fov_y_rad, ColorMode show);

 private:
  /// A texture, and a framebuffer for drawing into the texture.
  struct Layer {
    GlTexture texture;
    GlFramebuffer framebuffer;
  };
  static Layer makeLayer(GLenum format, uint32_t width_px, uint32_t height_px);
  void fit(const Framebuffer& picture);
  void drawLayer(const Layer& layer, const GlProgram& program) const;
  void drawLayers() const;

  GlProgram halving_program_, occlusion_program_, blur_program_, darkening_program_;
  GlVertexArray empty_array_;
  uint32_t width_px_ = 0, height_px_ = 0;  ///< size of the layers
  Layer depth_, occlusion_, blurred_;
};

}  // namespace lode::render
