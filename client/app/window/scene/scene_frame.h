#pragma once

#include "common/codec/model_summary.h"
#include "common/lattice.h"

namespace lode::app {

/// A scene's lattice that stays when models come late: with room around what is there, on each side 64 times
/// its longest side. Where the others are placed does not tell how far they reach: a georeferenced model is
/// millions of units away from that. Pure.
/// @param whole  of the models that are there.
Lattice latticeWithRoom(const ModelSummary& whole);

/// Its box, as far as it lies in another lattice: cut off where that ends. Pure.
LatticeBox boxIn(const Lattice& lattice, const ModelSummary& whole);

}  // namespace lode::app
