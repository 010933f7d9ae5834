#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <meshoptimizer.h>

#include "server/ingest/simplify/collapse.h"
#include "tests/bench/bench_models.h"
#include "tests/bench/fidelity_parts.h"
#include "tests/bench/print_row.h"

namespace lode::bench {
namespace {

constexpr size_t kSamples = 500000;  // samples in each direction
constexpr double kFirstStep = 0.9, kLadderStep = 0.5;

using test::SampledDistance;

struct Measured {
  double triangles;
  SampledDistance distance;
};

/// Returns triangle counts for simplifications of the whole model, in descending order, down to errors above
/// those of all cuts.
std::vector<size_t> ladderOf(size_t triangles, size_t fewest) {
  const auto whole = static_cast<double>(triangles);
  std::vector<size_t> ladder{static_cast<size_t>(kFirstStep * whole)};
  for (double count = kLadderStep * whole; count > static_cast<double>(fewest); count *= kLadderStep)
    ladder.push_back(static_cast<size_t>(count));
  return ladder;
}

/// Returns the smallest triangle count within an error, interpolated in log-log. Returns the whole model's
/// count if no simplification is within the error, and nothing if even the coarsest is.
/// @param ladder  by falling counts.
std::optional<double> trianglesAt(std::span<const Measured> ladder, double whole, double error,
                                  double SampledDistance::*kind) {
  for (size_t i = ladder.size(); i-- > 0;) {
    if (ladder[i].distance.*kind > error) continue;
    if (i + 1 == ladder.size()) return std::nullopt;
    const Measured &finer = ladder[i], &coarser = ladder[i + 1];
    const double from = std::log(coarser.distance.*kind), to = std::log(finer.distance.*kind);
    return coarser.triangles *
           std::pow(finer.triangles / coarser.triangles, (from - std::log(error)) / (from - to));
  }
  return whole;
}

std::vector<Measured> measureMeshoptimizer(const FileSurface& surface, const Original& original,
                                           std::span<const size_t> ladder) {
  std::vector<float> points;
  for (const glm::dvec3 p : surface.points)
    for (int k = 0; k < 3; ++k) points.push_back(static_cast<float>(p[k] - surface.points[0][k]));
  std::vector<unsigned> indices;
  for (const glm::u32vec3 t : surface.triangles) indices.insert(indices.end(), {t.x, t.y, t.z});
  std::vector<Measured> result;
  for (const size_t target : ladder) {
    std::vector<unsigned> simple(indices.size());
    simple.resize(meshopt_simplify(simple.data(), indices.data(), indices.size(), points.data(),
                                   points.size() / 3, 3 * sizeof(float), 3 * target, 1e9f, 0, nullptr));
    test::TriangleSoup soup;
    for (size_t i = 0; i < simple.size(); i += 3)
      soup.push_back(
          {surface.points[simple[i]], surface.points[simple[i + 1]], surface.points[simple[i + 2]]});
    result.push_back({static_cast<double>(soup.size()), original.distanceOf(soup)});
  }
  return result;
}

/// Measures collapse() on the whole model as one node without locked vertices, to find the cost of the
/// hierarchy.
std::vector<Measured> measureCollapse(const FileSurface& surface, const Original& original,
                                      std::span<const size_t> ladder) {
  FileNode node = nodeOf(surface);
  std::vector<Measured> result;
  ingest::collapse(std::move(node.mesh), ladder, {.max_position = node.extent},
                   [&](size_t, ingest::SimplifiedMesh&& simple) {
                     test::TriangleSoup soup = latticeSoup(simple.mesh);
                     for (test::Triangle3& t : soup)
                       for (glm::dvec3* p : {&t.a, &t.b, &t.c})
                         *p = node.lattice.origin + node.lattice.step * *p;
                     result.push_back({static_cast<double>(soup.size()), original.distanceOf(soup)});
                   });
  return result;
}

struct CutMeasured {
  const char* path;
  Measured measured;
};

/// Adds to each cut's row the ratio of its triangles to the simplifier's at equal error. Adds none if no
/// simplification is so coarse.
void addRatios(const std::string& simplifier, std::span<const Measured> ladder, double whole,
               std::span<const CutMeasured> cuts, std::vector<nlohmann::ordered_json>& rows) {
  for (const bool is_max : {true, false}) {
    double SampledDistance::*const kind = is_max ? &SampledDistance::max : &SampledDistance::rms;
    for (size_t i = 0; i < cuts.size(); ++i) {
      const auto theirs = trianglesAt(ladder, whole, cuts[i].measured.distance.*kind, kind);
      if (theirs)
        rows[i][simplifier + (is_max ? "_at_equal_largest" : "_at_equal_rms")] =
            cuts[i].measured.triangles / *theirs;
    }
  }
}

}  // namespace

void compareAtEqualError(const char* original, std::span<char* const> paths) {
  const FileSurface surface = readSurface(original);
  const Original measured(surface.soup(), kSamples);
  std::vector<CutMeasured> cuts;
  std::vector<nlohmann::ordered_json> rows;
  size_t fewest = surface.triangles.size();
  for (const char* path : paths) {
    const test::TriangleSoup soup = readSurface(path).soup();
    fewest = std::min(fewest, soup.size());
    cuts.push_back({path, {static_cast<double>(soup.size()), measured.distanceOf(soup)}});
    const SampledDistance& distance = cuts.back().measured.distance;
    rows.push_back(
        {{"cut", path}, {"triangles", soup.size()}, {"largest", distance.max}, {"rms", distance.rms}});
  }
  const std::vector<size_t> ladder = ladderOf(surface.triangles.size(), fewest / 3);
  const auto whole = static_cast<double>(surface.triangles.size());
  addRatios("of_meshoptimizer", measureMeshoptimizer(surface, measured, ladder), whole, cuts, rows);
  addRatios("of_collapse", measureCollapse(surface, measured, ladder), whole, cuts, rows);
  for (const auto& row : rows) printRow(row);
}

}  // namespace lode::bench
