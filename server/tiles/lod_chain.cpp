#include "server/tiles/lod_chain.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace lode::tiles {
namespace {

constexpr double kBelow = 1 - 1e-6;

/// Returns the numbers of the LODs that become tiles, finest first.
std::vector<uint32_t> thinned(const Node& node) {
  const auto count = static_cast<uint32_t>(node.lods.size()) - node.far_lods;
  std::vector<uint32_t> kept{0};
  for (uint32_t i = 1; i < count; ++i) {
    const Lod& finer = node.lods[kept.back()];
    const Lod& lod = node.lods[i];
    const bool differs = lod.triangles * kLeastTriangleRatio <= finer.triangles &&
                         lod.offModel() >= kLeastErrorRatio * finer.offModel();
    if (differs || i + 1 == count) kept.push_back(i);
  }
  return kept;
}

}  // namespace

double toNineDigits(double value) {
  std::array<char, 40> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, 8).ptr;
  double rounded = 0;
  std::from_chars(text.data(), end, rounded);
  return rounded;
}

std::vector<TileLod> tileChain(const Node& node, double above_model) {
  std::vector<uint32_t> lods = thinned(node);
  std::ranges::reverse(lods);
  std::vector<TileLod> chain;
  for (const uint32_t lod : lods) {
    double error = toNineDigits(node.lods[lod].offModel());
    if (error >= above_model) error = toNineDigits(above_model * kBelow);
    chain.push_back({lod, error});
    if (error == 0) break;
    above_model = error;
  }
  return chain;
}

}  // namespace lode::tiles
