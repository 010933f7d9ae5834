#pragma once

#include <initializer_list>
#include <string_view>

#include "client/render/gl_names.h"

namespace lode::render {

/// Compiles and links a program from texts in GLSL 4.50, without their first line; those of the fragment
/// shader follow one another.
/// @param definition  a name that is defined in both; none if it is empty.
/// @throws Error kInternal with the driver's first line: the sources are ours and need OpenGL 4.5 only.
GlProgram linkProgram(const char* vertex_source, std::initializer_list<const char*> fragment_sources,
                      std::string_view definition = {});

}  // namespace lode::render
