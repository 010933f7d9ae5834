#pragma once

#include "client/render/gl_names.h"

namespace lode::render {

/// Compiles and links a program from GLSL texts.
/// @throws Error kInternal with the driver's first line: the sources are ours and need OpenGL 4.5 only.
GlProgram linkProgram(const char* vertex_source, const char* fragment_source);

}  // namespace lode::render
