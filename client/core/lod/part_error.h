#pragma once

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"

namespace lode::core {

/// Returns an upper bound for the error of a part, in pixels of a camera's picture: CutPart::off_model,
/// projected at a lower bound of the distance to all visible points. A visible point may belong to the part's
/// mesh or to the original surface; both lie in the node's box, so the distance to the box is such a bound.
/// If the camera is near the box, the function searches the mesh for a better one. All points of the original
/// surface are within error_model of the mesh, so no visible point is nearer than the nearest triangle,
/// clipped to the picture, minus error_model. The search helps, for example, in the middle of a room: the eye
/// is inside the room's box, but meters from the walls.
/// @param lattice_step  size of a lattice step in model units; if 0, the function never searches the mesh.
/// @return 0 if nothing of the part is in the picture.
float partErrorPx(const CutPart& part, double lattice_step, const ViewFrustum& frustum);

}  // namespace lode::core
