#pragma once

#include <span>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/gl_names.h"

namespace lode::render {

/// A soft dark ellipse on level ground below an object.
struct ContactShadow {
  glm::dvec3 middle{0};            ///< centre of the ellipse, on the ground
  glm::dvec3 across{0}, along{0};  ///< horizontal semi-axes of the ellipse
  float depth = 0;                 ///< share of the light that the shadow removes at the centre, 0..1
};

/// Darkens ground that is already drawn. Draw the shadows before the objects on the ground. Create, use and
/// destroy the object on the thread of its OpenGL context.
class ContactShadows {
 public:
  ContactShadows();

  /// Draws all shadows in one pass. Where shadows overlap, the shares of light that they leave are
  /// multiplied. @param shadows  shadows in the view's model frame.
  void draw(std::span<const ContactShadow> shadows, const core::View& view, const Framebuffer& target);

 private:
  GlProgram program_;
  GlVertexArray array_;
  GlBuffer spots_;
};

}  // namespace lode::render
