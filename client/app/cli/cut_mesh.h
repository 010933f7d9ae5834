#pragma once

#include "client/core/lod/cut.h"
#include "common/mesh.h"

namespace lode::app {

/// The cut as one mesh: equal wedges of different parts become one vertex. Vertices and triangles come in the
/// order of the parts.
/// @throws Error kLimit if it has more vertices than an index can name.
Mesh weldCut(const core::Cut& cut, AttributeSet attributes);

}  // namespace lode::app
