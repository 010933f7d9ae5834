#pragma once

#include "server/ingest/nodes/built_node_record.h"

namespace lode::ingest {

/// Leaves out far LODs, but for the coarsest, that are farther off than the parent's finest LOD: a view
/// that shows the node could show the parent before it took them, but for a nearer sibling. Of a parent whose
/// finest LOD is large those stay that are up to twice as far off: a view of the whole model has such a
/// sibling. See docs/decisions/0011-lod-ladder.md.
void leaveOutIdleLods(FinishedNode& finished, const Node& parent);

}  // namespace lode::ingest
