#pragma once

namespace lode::render {

/// GLSL of the renderer, for linkProgram(). Names of uniforms and their locations: renderer.cpp. With
/// TEXTURED the mesh shaders sample textures: a driver that draws on the processor runs what is sampled for
/// every pixel, also of models that have none.
extern const char* const kMeshVertexShader;
extern const char* const kMeshFragmentShader;
extern const char* const kBackgroundVertexShader;
extern const char* const kBackgroundFragmentShader;

/// Bits of a draw's flags, as the shaders read them; depth, rung and a hash of the node
/// follow at bits 8, 16 and 24.
constexpr unsigned kDrawHasNormals = 1, kDrawHasColour = 2, kDrawLodColour = 4, kDrawTextured = 8;

}  // namespace lode::render
