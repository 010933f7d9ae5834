#include "client/render/culling/occlusion_culling.h"

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

OcclusionCulling fastestOcclusionCulling() {
  if (drawsInSoftware()) return OcclusionCulling::kReadBack;
  if (!GpuCulling::isPossible()) return OcclusionCulling::kOff;
  try {
    const GpuCulling compiles_its_shaders;
    return OcclusionCulling::kOnGpu;
  } catch (const Error&) {  // the driver has rejected the shaders
    return OcclusionCulling::kOff;
  }
}

}  // namespace lode::render
