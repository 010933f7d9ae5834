#include "client/app/cli/cut_mesh.h"

#include "common/io/mesh_joiner.h"

namespace lode::app {

Mesh weldCut(const core::Cut& cut, AttributeSet attributes) {
  MeshJoiner joiner(attributes, cut.triangles);
  for (const core::CutPart& part : cut.parts) joiner.add(*part.mesh);
  return joiner.finish();
}

}  // namespace lode::app
