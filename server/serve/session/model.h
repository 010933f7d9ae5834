#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/codec/model_summary.h"

namespace lode::serve {

class BlobReader;
struct ModelCounters;

/// A model that is offered: what sessions must know of it, and what reads its blobs. Immutable but for the
/// reader's notes; it lives as long as anybody has it open.
struct Model {
  ModelSummary summary;
  std::vector<uint32_t> blob_bytes;         ///< size of each blob by number; 0 is no blob
  uint32_t coarsest_blob = 0;               ///< the root's coarsest LOD; 0 if it has no triangles
  std::shared_ptr<const BlobReader> blobs;  ///< none where nothing is read, as in tests of sessions

  uint32_t blobBytes(uint32_t number) const noexcept {
    return number < blob_bytes.size() ? blob_bytes[number] : 0;
  }
};

/// A model that a connection has open.
struct OpenedModel {
  std::shared_ptr<const Model> model;
  Digest told;                        ///< the build that ModelReplaced was said of
  ModelCounters* counters = nullptr;  ///< none where nothing is counted
};

}  // namespace lode::serve
