#pragma once

#include "common/codec/draco_codec.h"
#include "tests/support/test_meshes.h"

namespace lode {

constexpr double kStep = 0x1p-6;  ///< of the lattice that tests encode payloads on

inline PayloadExpectation expectationOf(const Mesh& mesh, const EncodedPayload& payload) {
  return {static_cast<uint32_t>(mesh.triangles.size()), payload.vertices, mesh.attributes, test::boxOf(mesh)};
}

}  // namespace lode
