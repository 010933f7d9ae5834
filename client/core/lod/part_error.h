#pragma once

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"

namespace lode::core {

/// Returns an upper bound of the error in pixels of a part that a camera sees. The bound is
/// CutPart::off_model, projected at the distance of the nearest visible point. This point may belong to the
/// part's mesh or to the original surface, and lies inside the node's box. If the camera is near the box, the
/// function searches the mesh: all points of the original surface are within error_model of the mesh, so the
/// distance of any visible point is at least the distance of the nearest triangle, clipped to the picture,
/// minus error_model. This bound helps, for example, if the eye is in the middle of a room: inside the room's
/// box, but meters from the walls.
/// @param lattice_step  size of a lattice step in model units; 0: the function never searches the mesh.
/// @return 0 if nothing of the part is in the picture.
float partErrorPx(const CutPart& part, double lattice_step, const ViewFrustum& frustum);

}  // namespace lode::core
