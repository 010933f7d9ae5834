#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "tests/bench/bench_models.h"
#include "tests/bench/fidelity_parts.h"
#include "tests/bench/print_row.h"

namespace lode::bench {
namespace {

constexpr size_t kSamples = 1000000;  // samples in each direction

struct Reference {
  double triangles, rms;
};
/// Errors of meshoptimizer 1.2 on the whole bunny.
constexpr std::array<Reference, 3> kBunny{{{642, 2.30e-3}, {1822, 9.16e-4}, {18799, 1.13e-4}}};

/// Returns the reference error at a triangle count, interpolated in log-log.
double bunnyReference(double triangles) {
  const Reference* from = triangles < kBunny[1].triangles ? &kBunny[0] : &kBunny[1];
  const double slope = std::log(from[1].rms / from[0].rms) / std::log(from[1].triangles / from[0].triangles);
  return from[0].rms * std::pow(triangles / from[0].triangles, slope);
}

void print(size_t triangles, const test::SampledDistance& distance, bool is_bunny, const std::string& name) {
  nlohmann::ordered_json row{
      {"cut", name}, {"triangles", triangles}, {"rms", distance.rms}, {"largest", distance.max}};
  if (is_bunny) {
    row["reference"] = bunnyReference(static_cast<double>(triangles));
    row["ratio"] = distance.rms / row["reference"].get<double>();
  }
  printRow(row);
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

}  // namespace lode::bench
