#pragma once

namespace lode::render {

/// GLSL sources of the mesh programs, for linkProgram(). mesh_drawer.cpp has the uniform locations. Macros
/// select the features. TEXTURED samples textures. FADING draws a dithered share of the pixels and prevents
/// early depth tests. CUT_OUT discards transparent pixels. VIEWS draws colour modes other than kSurface. WIRE
/// draws triangle edges. SECTION removes the half beyond a plane, and draws the cut surface. Definition of
/// the macro CORNER, the variables that one shader stage passes to the next.
extern const char* const kCorner;
extern const char* const kTintedCorner;  ///< variant of kCorner for programs with VIEWS
extern const char* const kMeshVertexShader;
extern const char* const kWireGeometryShader;  ///< geometry shader of programs with WIRE
extern const char* const kWireShader;
extern const char* const kMeshFragmentShader;

/// Bits of DrawState::flags. The shaders hard-code the same values.
constexpr unsigned kDrawHasNormals = 1, kDrawHasColour = 2, kDrawTinted = 4, kDrawTextured = 8,
                   kDrawUnlit = 16, kDrawNormals = 32, kDrawTexels = 64, kDrawClay = 128, kDrawMatcap = 256;

}  // namespace lode::render
