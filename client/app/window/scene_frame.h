#pragma once

#include <span>

#include "client/app/cli/scene_file.h"
#include "common/lattice.h"
#include "common/model_summary.h"

namespace lode::app {

/// A scene's lattice that stays when models come late: with room around what is there and where the others
/// stand, as much on each side as all of that reaches. Pure.
/// @param whole  of the models that are there.
Lattice latticeWithRoom(const ModelSummary& whole, std::span<const SceneInstance> instances);

/// Its box, as far as it lies in another lattice. Pure.
LatticeBox boxIn(const Lattice& lattice, const ModelSummary& whole);

}  // namespace lode::app
