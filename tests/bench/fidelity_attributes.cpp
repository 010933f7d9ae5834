#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "server/ingest/simplify/collapse.h"
#include "tests/bench/attribute_loss.h"
#include "tests/bench/fidelity_parts.h"

namespace lode::bench {
namespace {

constexpr size_t kSamples = 200000;  // each way
constexpr std::array<size_t, 3> kReductions{4, 10, 30};

std::vector<AttributeLoss> lossesAt(const FileNode& model, const AttributeField& original,
                                    std::span<const size_t> targets, double weight,
                                    std::vector<size_t>& triangles) {
  std::vector<AttributeLoss> losses;
  triangles.clear();
  ingest::collapse(model.mesh, targets, {.max_position = model.extent, .attribute_weight = weight},
                   [&](size_t, ingest::SimplifiedMesh&& simple) {
                     if (simple.mesh.triangles.empty()) return;
                     triangles.push_back(simple.mesh.triangles.size());
                     losses.push_back(attributeLoss(original, simple.mesh, kSamples));
                   });
  return losses;
}

void printRatio(const char* what, double with, double without) {
  std::printf("  %s %.3g / %.3g = %.2f", what, with, without, without > 0 ? with / without : 0);
}

}  // namespace

void compareAttributes(std::span<char* const> models) {
  std::printf("means with attribute quadrics / without, at equal triangle counts\n");
  for (const char* path : models) {
    const FileNode model = readNode(path);
    const AttributeSet has = model.mesh.attributes;
    const AttributeField original(model.mesh);
    std::printf("%s: %zu triangles\n", path, model.mesh.triangles.size());
    std::vector<size_t> targets, triangles, plain_triangles;
    for (const size_t reduction : kReductions)
      targets.push_back(std::max<size_t>(model.mesh.triangles.size() / reduction, 4));
    const auto with = lossesAt(model, original, targets, 1, triangles);
    const auto without = lossesAt(model, original, targets, 0, plain_triangles);
    for (size_t i = 0; i < std::min(with.size(), without.size()); ++i) {
      std::printf("%8zu (%zu):", triangles[i], plain_triangles[i]);
      if (has.has(AttributeSet::kColour)) printRatio("colour", with[i].colour, without[i].colour);
      if (has.has(AttributeSet::kNormal))
        printRatio("normal (degrees)", with[i].normal_deg, without[i].normal_deg);
      if (has.has(AttributeSet::kTexture)) {
        const double unit = model.texture_scale / 65536;
        printRatio("texture", with[i].texture * unit, without[i].texture * unit);
        std::printf(" (in other charts %.1f %%, %.1f %%)", 100 * with[i].other_charts,
                    100 * without[i].other_charts);
      }
      printRatio("rms", with[i].surface, without[i].surface);
      std::printf("\n");
    }
  }
}

}  // namespace lode::bench
