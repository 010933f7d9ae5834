#include "client/render/gl/offscreen_context.h"

#include <array>
#include <string>
#include <string_view>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "common/error.h"

namespace lode::render {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw Error(ErrorCode::kIo, "cannot draw off-screen: " + what +
                                  "; install a driver with EGL and OpenGL 4.5 (Debian: libegl1 libegl-mesa0 "
                                  "libgl1-mesa-dri), or use `lodestream fetch`, which draws nothing");
}

bool hasExtension(const char* extensions, std::string_view name) {
  return extensions != nullptr && std::string_view(extensions).find(name) != std::string_view::npos;
}

/// Opens Mesa's surfaceless platform, or else the first EGL device that initializes.
EGLDisplay openDisplay() {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!hasExtension(client, "EGL_EXT_platform_base")) fail("EGL has no platform without a display");
  EGLint major = 0, minor = 0;
  if (hasExtension(client, "EGL_MESA_platform_surfaceless")) {
    const EGLDisplay display =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display != EGL_NO_DISPLAY && eglInitialize(display, &major, &minor)) return display;
  }
  if (hasExtension(client, "EGL_EXT_device_enumeration") && hasExtension(client, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count)) {
      for (EGLint i = 0; i < count; ++i) {
        const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
        if (display != EGL_NO_DISPLAY && eglInitialize(display, &major, &minor)) return display;
      }
    }
  }
  fail("EGL opens neither a surfaceless display nor a device");
}

}  // namespace

struct OffscreenContext::Impl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  ~Impl() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    // Keep the display initialized: terminating the display would unload the driver, which leaks memory, and
    // the next context would load the driver again.
    eglReleaseThread();
  }
};

OffscreenContext::OffscreenContext() : impl_(std::make_unique<Impl>()) {
  impl_->display = openDisplay();
  if (!eglBindAPI(EGL_OPENGL_API)) fail("EGL has no desktop OpenGL");
  const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                         4,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         5,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
  // Pass no config: the context never draws to a surface, and some drivers have no default config for this
  // display.
  impl_->context = eglCreateContext(impl_->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
  if (impl_->context == EGL_NO_CONTEXT) fail("the driver makes no OpenGL 4.5 core context");
  if (!eglMakeCurrent(impl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, impl_->context)) {
    fail("the context cannot be used without a surface");
  }
}

OffscreenContext::~OffscreenContext() = default;

}  // namespace lode::render
