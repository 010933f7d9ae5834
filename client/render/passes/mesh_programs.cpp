#include "client/render/passes/mesh_programs.h"

#include <string_view>
#include <utility>
#include <vector>

#include "client/render/passes/shader_program.h"
#include "client/render/passes/shaders.h"

namespace lode::render {
namespace {

constexpr std::array<std::pair<MeshPrograms::Part, std::string_view>, 5> kDefinitions{
    {{MeshPrograms::kFading, "FADING"},
     {MeshPrograms::kTextured, "TEXTURED"},
     {MeshPrograms::kCutOut, "CUT_OUT"},
     {MeshPrograms::kViews, "VIEWS"},
     {MeshPrograms::kWire, "WIRE"}}};

}  // namespace

MeshPrograms::MeshPrograms() {
  for (const unsigned parts : {0u, unsigned{kFading}, unsigned{kTextured}, unsigned{kFading | kTextured}})
    with(parts);
}

const GlProgram& MeshPrograms::with(unsigned parts) {
  GlProgram& program = programs_.at(parts);
  if (program) return program;
  std::vector<std::string_view> definitions{(parts & kViews) != 0 ? kTintedCorner : kCorner};
  for (const auto& [part, definition] : kDefinitions)
    if ((parts & part) != 0) definitions.push_back(definition);
  program = linkProgram(kMeshVertexShader, {kLightShader, kWireShader, kMeshFragmentShader}, definitions,
                        (parts & kWire) != 0 ? kWireGeometryShader : nullptr);
  return program;
}

}  // namespace lode::render
