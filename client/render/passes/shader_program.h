#pragma once

#include <initializer_list>
#include <span>
#include <string_view>

#include "client/render/gl_names.h"

namespace lode::render {

/// Compiles and links a program from texts in GLSL 4.50, without their first line; those of the fragment
/// shader follow one another.
/// @param definitions      names that are defined in all, or names and what they stand for.
/// @param geometry_source  null: there is no such shader.
/// @throws Error kInternal with the driver's first line: the sources are ours and need OpenGL 4.5 only.
GlProgram linkProgram(const char* vertex_source, std::initializer_list<const char*> fragment_sources,
                      std::span<const std::string_view> definitions = {},
                      const char* geometry_source = nullptr);

/// The same of what computes. @throws as above.
GlProgram linkComputeProgram(const char* source);

}  // namespace lode::render
