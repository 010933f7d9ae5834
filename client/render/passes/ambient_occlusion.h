#pragma once

#include <cstdint>

#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"
#include "client/render/shown_colours.h"

namespace lode::render {

/// Darkens what little of the sky reaches: creases, hollows and feet, as the depth of a drawn picture shows
/// them. Made, used and destroyed on the thread of its context.
/// How far it looks is a share of the picture's height, so that a model looks alike from afar and close up,
/// and what it does follows from this picture alone: the same depth gives the same bits. Source: McGuire,
/// Mara and Luebke, Scalable Ambient Obscurance, 2012.
class AmbientOcclusion {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  AmbientOcclusion();

  /// To be called once, when all models of a picture are drawn, before it is resolved. Touches no sample of
  /// the background, and nothing unless surfaces are shown in their light: other colours mean something.
  /// @param picture  of several samples a pixel.
  /// Leaves behind: bound framebuffer, program, vertex array, textures, depth state.
  void darken(const Framebuffer& picture, double fov_y_rad, ColorMode show);

 private:
  /// A texture that is drawn to.
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
  uint32_t width_px_ = 0, height_px_ = 0;  ///< of the layers
  Layer depth_, occlusion_, blurred_;
};

}  // namespace lode::render
