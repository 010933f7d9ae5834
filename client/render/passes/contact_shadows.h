#pragma once

#include <span>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"

namespace lode::render {

/// The soft dark spot where something stands on level ground.
struct ContactShadow {
  glm::dvec3 middle{0};            ///< on the ground
  glm::dvec3 across{0}, along{0};  ///< from there to its ends; level
  float depth = 0;                 ///< of light that is missing in the middle, 0..1
};

/// Darkens a ground that has been drawn, before anything that stands on it. Made, used and destroyed on the
/// thread of its context.
class ContactShadows {
 public:
  ContactShadows();

  /// In one pass; where several meet, they darken together. @param shadows  in the frame of the view.
  void draw(std::span<const ContactShadow> shadows, const core::View& view, const Framebuffer& target);

 private:
  GlProgram program_;
  GlVertexArray array_;
  GlBuffer spots_;
};

}  // namespace lode::render
