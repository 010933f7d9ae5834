#pragma once

#include <utility>

#include <epoxy/gl.h>

namespace lode::render {

/// Owns one OpenGL name. Create, use and destroy it on the thread where its context is current.
template <typename Traits>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) noexcept : name_(name) {}
  ~GlName() { reset(); }
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    if (this != &other) {
      reset();
      name_ = std::exchange(other.name_, 0);
    }
    return *this;
  }

  GLuint get() const noexcept { return name_; }
  explicit operator bool() const noexcept { return name_ != 0; }
  void reset() noexcept {
    if (name_ != 0) Traits::destroy(name_);
    name_ = 0;
  }
  static GlName create() { return GlName(Traits::create()); }

 private:
  GLuint name_ = 0;
};

struct BufferTraits {
  static GLuint create() noexcept {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    return name;
  }
  static void destroy(GLuint name) noexcept { glDeleteBuffers(1, &name); }
};

struct VertexArrayTraits {
  static GLuint create() noexcept {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    return name;
  }
  static void destroy(GLuint name) noexcept { glDeleteVertexArrays(1, &name); }
};

struct RenderbufferTraits {
  static GLuint create() noexcept {
    GLuint name = 0;
    glCreateRenderbuffers(1, &name);
    return name;
  }
  static void destroy(GLuint name) noexcept { glDeleteRenderbuffers(1, &name); }
};

struct FramebufferTraits {
  static GLuint create() noexcept {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    return name;
  }
  static void destroy(GLuint name) noexcept { glDeleteFramebuffers(1, &name); }
};

template <GLenum kTarget>
struct TextureTraits {
  static GLuint create() noexcept {
    GLuint name = 0;
    glCreateTextures(kTarget, 1, &name);
    return name;
  }
  static void destroy(GLuint name) noexcept { glDeleteTextures(1, &name); }
};

struct TimeQueryTraits {
  static GLuint create() noexcept {
    GLuint name = 0;
    glCreateQueries(GL_TIME_ELAPSED, 1, &name);
    return name;
  }
  static void destroy(GLuint name) noexcept { glDeleteQueries(1, &name); }
};

struct ProgramTraits {
  static GLuint create() noexcept { return glCreateProgram(); }
  static void destroy(GLuint name) noexcept { glDeleteProgram(name); }
};

using GlBuffer = GlName<BufferTraits>;
using GlVertexArray = GlName<VertexArrayTraits>;
using GlRenderbuffer = GlName<RenderbufferTraits>;
using GlFramebuffer = GlName<FramebufferTraits>;
using GlTexture = GlName<TextureTraits<GL_TEXTURE_2D>>;
using GlTextureArray = GlName<TextureTraits<GL_TEXTURE_2D_ARRAY>>;
using GlMultisampleTexture = GlName<TextureTraits<GL_TEXTURE_2D_MULTISAMPLE>>;
using GlTimeQuery = GlName<TimeQueryTraits>;
using GlProgram = GlName<ProgramTraits>;

}  // namespace lode::render
