#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "common/lattice.h"
#include "common/mesh.h"
#include "common/node_key.h"

namespace lode::render {

/// Which of several places a part stands at.
struct ShownInstance {
  uint32_t number = 0;          ///< its nodes have other colours than those of other places
  std::string_view model = {};  ///< for legends; empty where there is one model
  uint32_t nth = 0;             ///< of the model's places, from 1; 0: it has one

  bool operator==(const ShownInstance&) const = default;
};

/// Where the triangles of a mesh are, kClusterTriangles at a time; somewhere in it where that is not known.
struct MeshClusters {
  std::vector<LatticeBox> boxes;
  /// By place where the model stands, as far as looked at, and cluster: by others, in the last frame.
  std::vector<std::vector<bool>> hidden;
};

/// What a draw call needs of a mesh on the GPU.
struct DrawItem {
  uint32_t page = 0;
  uint32_t base_vertex = 0, first_index = 0, index_count = 0;
  uint32_t first_box_word = 0;  ///< of its clusters' boxes, in words of the page
  LatticeBox box;
  std::shared_ptr<MeshClusters> clusters;  ///< never null in what is drawn
  AttributeSet attributes;
  NodeKey node;
  uint32_t lod = 0;
  float error_rad = 0;  ///< as the eye saw it when the cut was made, whatever the picture's pixels
  float error_model = 0;
  float threshold_rad = 0, complete_rad = 0;  ///< likewise: see ShownThresholds
  float age_s = 0;                            ///< that it is in the picture
  ShownInstance instance = {};                ///< where it was drawn last
};

}  // namespace lode::render
