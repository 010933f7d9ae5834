#pragma once

#include <limits>
#include <string>
#include <tuple>

#include "common/codec/hierarchy_page.h"
#include "proto/messages.h"

namespace lode::proto::test {

inline Digest nameOf(uint8_t seed) {
  Digest name;
  for (size_t i = 0; i < name.bytes.size(); ++i) name.bytes[i] = static_cast<std::byte>(seed + 7 * i);
  return name;
}

/// A summary in which every field differs from its default.
inline ModelSummary sampleSummary(const std::string& name = "bunny") {
  ModelSummary summary;
  summary.name = name;
  summary.build_id = nameOf(3);
  summary.lattice = {{-1.5, 1e6, 0.25}, 1.0 / 1024};
  summary.box = {{1, 2, 3}, {1000, kMaxLattice, 77}};
  summary.attributes.bits = AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kComputedNormal;
  summary.triangles = 69451;
  summary.dropped = 3;
  summary.stored_triangles = 1ull << 40;
  summary.nodes = 1234;
  summary.payloads = 2345;
  summary.bytes = 5'000'000'000;
  summary.depth = 5;
  summary.max_error_model = 0.125f;
  summary.triangles_per_node = 16384;
  summary.root_page = {17, 4000, nameOf(9)};
  summary.textures = {18, 250, nameOf(11)};
  return summary;
}

/// One of each message, in the order of LODE_MESSAGES, no field at its default.
inline auto sampleMessages() {
  const float inf = std::numeric_limits<float>::infinity();
  return std::tuple{Hello{1, 3, 0x8000000000000001, "s3cret", "a viewer"},
                    Welcome{2, 5, 100, "lodestreamd"},
                    List{},
                    Models{{sampleSummary("a"), sampleSummary("b")}},
                    Open{"bunny", nameOf(1)},
                    Opened{4, sampleSummary()},
                    Requests{4,
                             {{RequestAction::kAdd, RequestClass::kVisible, 1, 20, 12.5f},
                              {RequestAction::kAdd, RequestClass::kPrefetch, 3, 22, inf},
                              {RequestAction::kReprioritise, RequestClass::kMargin, 2, 0, 3},
                              {RequestAction::kCancel, RequestClass::kVisible, 0xFFFFFFFF, 0, 0}}},
                    Credit{0xFFFFFFFFFFFFFFFF},
                    Cancelled{9},
                    ErrorMessage{WireError::kDamagedStore, 12, true, "blob 3 is damaged — Ärger"},
                    GoAway{"the server is stopping"},
                    ModelReplaced{6},
                    Ping{0x1122334455667788},
                    Pong{0x8877665544332211},
                    Close{7},
                    Closed{8}};
}

/// Calls action(message) for each of sampleMessages().
void forEachSample(const auto& action) {
  std::apply([&](const auto&... message) { (action(message), ...); }, sampleMessages());
}

}  // namespace lode::proto::test
