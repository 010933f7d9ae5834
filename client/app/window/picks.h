#pragma once

#include <string>
#include <vector>

#include "client/core/cut_probe.h"
#include "common/model_summary.h"

namespace lode::app {

/// The last two points that were clicked on, as text.
class Picks {
 public:
  void add(const core::Hit& hit, const ModelSummary& model);
  void clear() noexcept { picks_.clear(); }

  /// Of the last point: coordinates, node, rung, error, colour; and how far it is from the one before.
  /// Empty without one.
  std::vector<std::string> lines() const;

 private:
  struct Pick {
    glm::dvec3 position;  ///< true coordinates
    NodeKey node;
    uint32_t rung = 0;
    float error_px = 0;
    double step = 1;  ///< of the lattice
    glm::u8vec4 colour{255};
    bool has_colour = false;
  };
  std::vector<Pick> picks_;
};

}  // namespace lode::app
