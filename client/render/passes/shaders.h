#pragma once

namespace lode::render {

/// GLSL of the renderer, for linkProgram(). Names of uniforms and their locations: renderer.cpp. With
/// TEXTURED the mesh shaders sample textures: a driver that draws on the processor runs what is sampled for
/// every pixel, also of models that have none. With FADING they draw a share of the pixels, which costs where
/// depth could be tested first. With WIRE they draw the edges of triangles.
extern const char* const kCorner;        ///< a definition: what the shaders of a mesh hand on of a corner
extern const char* const kTintedCorner;  ///< and where VIEWS is defined
extern const char* const kMeshVertexShader;
extern const char* const kWireGeometryShader;  ///< between the others, for a wireframe
extern const char* const kLightShader;         ///< before the one below, as the next
extern const char* const kWireShader;
extern const char* const kMeshFragmentShader;
extern const char* const kBackgroundVertexShader;
extern const char* const kBackgroundFragmentShader;
extern const char* const kWholeVertexShader;  ///< one triangle over all of the target, at depth 0

/// Bits of a draw's flags, as the shaders read them.
constexpr unsigned kDrawHasNormals = 1, kDrawHasColour = 2, kDrawTinted = 4, kDrawTextured = 8,
                   kDrawUnlit = 16, kDrawNormals = 32, kDrawTexels = 64;

}  // namespace lode::render
