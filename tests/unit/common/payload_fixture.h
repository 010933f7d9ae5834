#pragma once

#include "common/codec/draco_codec.h"
#include "tests/support/test_meshes.h"

namespace lode {

constexpr double kStep = 0x1p-6;  ///< lattice step of the payloads in tests

inline PayloadExpectation expectationOf(const Mesh& mesh, const EncodedPayload& payload) {
  return {static_cast<uint32_t>(mesh.triangles.size()), payload.vertices, mesh.attributes, test::boxOf(mesh)};
}

}  // namespace lode
