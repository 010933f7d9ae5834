#pragma once

#include <span>

#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// Gives a leaf computed normals: one a fan, so that a position on a crease gets several wedges.
/// @param border  what the leaf shares with others, by position: those normals are the table's.
void giveLeafNormals(NodeMesh& mesh, std::span<const BorderVertex> border, const CreaseAngle& crease);

}  // namespace lode::ingest
