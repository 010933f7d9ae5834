#include "client/render/gl/shader_program.h"

#include <span>
#include <string>
#include <vector>

#include "common/error.h"

namespace lode::render {
namespace {

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

void attachShader(GLuint program, GLenum kind, const std::string& head,
                  std::initializer_list<const char*> sources) {
  const GLuint shader = glCreateShader(kind);
  std::vector<const char*> texts{head.c_str()};
  texts.insert(texts.end(), sources);
  glShaderSource(shader, static_cast<GLsizei>(texts.size()), texts.data(), nullptr);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  std::string log(1024, '\0');
  if (compiled == GL_FALSE) glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glAttachShader(program, shader);
  glDeleteShader(shader);
  if (compiled == GL_FALSE) {
    throw Error(ErrorCode::kInternal,
                "the graphics driver does not compile a shader of Lodestream: " + firstLine(log.c_str()) +
                    "; update the driver, or set LIBGL_ALWAYS_SOFTWARE=1");
  }
}

void link(GLuint program) {
  glLinkProgram(program);
  GLint linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == GL_FALSE) {
    std::string log(1024, '\0');
    glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw Error(ErrorCode::kInternal,
                "the graphics driver does not link a program of Lodestream: " + firstLine(log.c_str()) +
                    "; update the driver, or set LIBGL_ALWAYS_SOFTWARE=1");
  }
}

std::string headOf(std::span<const std::string_view> definitions) {
  std::string head = "#version 450 core\n";
  for (const std::string_view definition : definitions) head += "#define " + std::string(definition) + "\n";
  return head;
}

}  // namespace

GlProgram linkProgram(const char* vertex_source, std::initializer_list<const char*> fragment_sources,
                      std::span<const std::string_view> definitions, const char* geometry_source) {
  const std::string head = headOf(definitions);
  GlProgram program = GlProgram::create();
  attachShader(program.get(), GL_VERTEX_SHADER, head, {vertex_source});
  if (geometry_source != nullptr) attachShader(program.get(), GL_GEOMETRY_SHADER, head, {geometry_source});
  attachShader(program.get(), GL_FRAGMENT_SHADER, head, fragment_sources);
  link(program.get());
  return program;
}

GlProgram linkComputeProgram(const char* source) {
  GlProgram program = GlProgram::create();
  attachShader(program.get(), GL_COMPUTE_SHADER, headOf({}), {source});
  link(program.get());
  return program;
}

const char* const kFullScreenVertexShader = R"glsl(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)glsl";

}  // namespace lode::render
