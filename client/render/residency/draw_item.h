#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "common/lattice.h"
#include "common/mesh.h"
#include "common/node_key.h"

namespace lode::render {

/// Identifies an instance of a model among the instances of a picture.
struct ShownInstance {
  uint32_t number = 0;          ///< seed of the node colours, which differ between instances
  std::string_view model = {};  ///< name of the model for legends; empty if there is only one model
  uint32_t nth = 0;             ///< number among the model's instances, from 1; 0 for the only instance

  bool operator==(const ShownInstance&) const = default;
};

/// Clusters of kClusterTriangles triangles of a mesh.
struct MeshClusters {
  std::vector<LatticeBox> boxes;  ///< boxes of the clusters; the mesh's box if the mesh has no cluster boxes
  /// Flags by instance and cluster: true if other geometry hid the cluster in the last frame.
  std::vector<std::vector<bool>> hidden;
};

/// A mesh on the GPU, as a draw call needs it.
struct DrawItem {
  uint32_t page = 0;
  uint32_t base_vertex = 0, first_index = 0, index_count = 0;
  uint32_t first_box_word = 0;  ///< offset of the mesh's cluster boxes in 32-bit words of the page
  LatticeBox box;
  std::shared_ptr<MeshClusters> clusters;  ///< clusters of the mesh; null if the part has no triangles
  AttributeSet attributes;
  NodeKey node;
  uint32_t lod = 0;
  float error_rad = 0;  ///< projected error as an angle, for the view that the cut was made for
  float error_model = 0;
  float threshold_rad = 0, complete_rad = 0;  ///< thresholds of the part as angles, see ShownThresholds
  float age_s = 0;                            ///< time since the part entered the picture
  ShownInstance instance = {};                ///< instance that drew the part last
};

}  // namespace lode::render
