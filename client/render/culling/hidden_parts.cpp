#include "client/render/culling/hidden_parts.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <epoxy/gl.h>

#include "client/render/culling/gpu_culling.h"
#include "common/error.h"

namespace lode::render {

bool drawsInSoftware() {
  const std::string_view name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  constexpr std::array<std::string_view, 3> kSoftware{"llvmpipe", "softpipe", "SwiftShader"};
  return std::ranges::any_of(
      kSoftware, [&](std::string_view known) { return name.find(known) != std::string_view::npos; });
}

HiddenParts fastestHiddenParts() {
  if (drawsInSoftware()) return HiddenParts::kReadBack;
  if (!GpuCulling::isPossible()) return HiddenParts::kDrawn;
  try {
    const GpuCulling proves_its_shaders;
    return HiddenParts::kFoundOnGpu;
  } catch (const Error&) {  // which the driver rejects
    return HiddenParts::kDrawn;
  }
}

}  // namespace lode::render
