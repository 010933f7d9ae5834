#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>

#include "tests/bench/bench_models.h"
#include "tests/bench/fidelity_parts.h"
#include "tests/bench/paper_operator.h"

namespace lode::bench {
namespace {

constexpr size_t kSamples = 1000000;  // each way

struct Reference {
  double triangles, rms;
};
/// meshoptimizer 1.2 on the whole bunny.
constexpr std::array<Reference, 3> kBunny{{{642, 2.30e-3}, {1822, 9.16e-4}, {18799, 1.13e-4}}};

/// Interpolated in log-log.
double bunnyReference(double triangles) {
  const Reference* from = triangles < kBunny[1].triangles ? &kBunny[0] : &kBunny[1];
  const double slope = std::log(from[1].rms / from[0].rms) / std::log(from[1].triangles / from[0].triangles);
  return from[0].rms * std::pow(triangles / from[0].triangles, slope);
}

void print(size_t triangles, const test::SampledDistance& distance, bool is_bunny, const std::string& name) {
  std::printf("%9zu triangles  rms %.3e  largest %.3e of the diagonal", triangles, distance.rms,
              distance.max);
  if (is_bunny) {
    const double reference = bunnyReference(static_cast<double>(triangles));
    std::printf("  reference %.3e  ours / reference %.3f", reference, distance.rms / reference);
  }
  std::printf("  %s\n", name.c_str());
}

}  // namespace

void compareCuts(const char* original, std::span<char* const> cuts) {
  const Original measured(readSurface(original).soup(), kSamples);
  const bool is_bunny = std::string_view(original).find("bun") != std::string_view::npos;
  for (const char* cut : cuts) {
    const test::TriangleSoup soup = readSurface(cut).soup();
    print(soup.size(), measured.distanceOf(soup), is_bunny, cut);
  }
}

// A cut of the paper's operator has the triangles that its leaves and its depth make; the count that comes
// closest to each of the reference's is taken, over all depths and leaves of 4 to 4096 triangles.
void comparePaper(const char* original) {
  const FileNode model = readNode(original);
  const Original measured(latticeSoup(model.mesh), kSamples);
  struct Cut {
    test::TriangleSoup soup;
    std::string name;
  };
  std::array<Cut, kBunny.size()> nearest;
  for (uint32_t leaf_triangles = 4; leaf_triangles <= 4096; leaf_triangles *= 2) {
    simplifyAsThePaper(model, leaf_triangles, [&](int depth, test::TriangleSoup&& soup) {
      for (size_t i = 0; i < nearest.size(); ++i) {
        const auto away = [&](size_t triangles) {
          return std::abs(std::log((static_cast<double>(triangles) + 1) / kBunny[i].triangles));
        };
        if (away(soup.size()) < away(nearest[i].soup.size())) {
          nearest[i] = {soup, "leaves of " + std::to_string(leaf_triangles) + ", nodes at depth " +
                                  std::to_string(depth)};
        }
      }
    });
  }
  for (const Cut& cut : nearest) print(cut.soup.size(), measured.distanceOf(cut.soup), true, cut.name);
}

}  // namespace lode::bench
