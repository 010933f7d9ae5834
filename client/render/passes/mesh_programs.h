#pragma once

#include <array>
#include <cstdint>

#include "client/render/gl_names.h"

namespace lode::render {

/// The programs that draw meshes. A processor that draws runs both sides of a shader's branches for every
/// pixel: what most pictures do not need is in programs of its own. Used on the thread of its context.
class MeshPrograms {
 public:
  enum Part : uint8_t {
    kFading = 1,    ///< a share of the pixels
    kTextured = 2,  ///< with images
    kCutOut = 4,    ///< and what these leave clear left out by whole pixels
    kViews = 8,     ///< of what is not the surface in its light
    kWire = 16,     ///< with the edges of triangles, of which the driver then runs through each
  };

  /// Links those of surfaces. @throws Error kInternal if the driver rejects a shader.
  MeshPrograms();

  /// Links it where it is the first time. @param parts  of Part. @throws as the constructor.
  const GlProgram& with(unsigned parts);

 private:
  std::array<GlProgram, 32> programs_;
};

}  // namespace lode::render
