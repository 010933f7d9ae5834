#pragma once

#include <initializer_list>
#include <span>
#include <string_view>

#include "client/render/gl/gl_names.h"

namespace lode::render {

/// Vertex shader that draws one triangle at depth 0 over the whole target.
extern const char* const kFullScreenVertexShader;

/// Compiles and links a program from GLSL 4.50 sources without their #version line. The fragment sources are
/// concatenated.
/// @param definitions      macros for all shaders: names, or names and values separated by a space.
/// @param geometry_source  source of the geometry shader, or null for none.
/// @throws Error kInternal with the first line of the driver's log. The error is internal, because every
/// OpenGL 4.5 driver should accept the sources.
GlProgram linkProgram(const char* vertex_source, std::initializer_list<const char*> fragment_sources,
                      std::span<const std::string_view> definitions = {},
                      const char* geometry_source = nullptr);

/// Compiles and links a compute program. @throws the same errors as linkProgram().
GlProgram linkComputeProgram(const char* source);

}  // namespace lode::render
