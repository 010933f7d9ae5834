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
  uint32_t number = 0;          ///< number of the instance in the picture; selects the node colours
  std::string_view model = {};  ///< name of the model for legends; empty if the picture has one model
  /// Number among the model's instances, counted from 1; 0 if the model has only one instance.
  uint32_t nth = 0;

  bool operator==(const ShownInstance&) const = default;
};

/// The clusters of a mesh: runs of kClusterTriangles triangles.
struct MeshClusters {
  /// Boxes of the clusters. If Mesh::cluster_boxes is empty, each cluster has the box of the whole mesh.
  std::vector<LatticeBox> boxes;
  /// Flags, indexed by instance and cluster: true if other geometry hid the cluster in the last frame.
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
  float error_rad = 0;  ///< projected error as an angle, in the view for which the cut was made
  float error_model = 0;
  /// The part's thresholds for ShownThresholds::drawn and ShownThresholds::complete, as angles.
  float threshold_rad = 0, complete_rad = 0;
  float age_s = 0;              ///< time since the part entered the picture
  ShownInstance instance = {};  ///< instance that drew the part last
};

}  // namespace lode::render
