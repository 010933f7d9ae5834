#pragma once

#include <string>

namespace lode::web {

/// Features of the mesh program, as macros select them: see client/render/passes/mesh_shaders.h.
struct ShaderParts {
  bool textured = false;  ///< TEXTURED
  bool cut_out = false;   ///< CUT_OUT
  bool views = false;     ///< VIEWS
  bool wire = false;      ///< WIRE; no two triangles may share a vertex
};

/// GLSL ES 3.00 sources without their #version line.
struct EsShaders {
  std::string vertex, fragment;
};

/// Translates the mesh program of the desktop client to GLSL ES 3.00, so that both clients draw a model
/// alike. Differences: a vertex is one or two vectors of 32-bit words, which the shader unpacks; uniforms
/// replace the state of a draw call; an integer texture replaces the table of tiles; depth is from -1 to 1
/// and grows with distance; colours leave the shader as sRGB.
EsShaders esShaders(const ShaderParts& parts);

}  // namespace lode::web
