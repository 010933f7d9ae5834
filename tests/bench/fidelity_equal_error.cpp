#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include <meshoptimizer.h>

#include "server/ingest/simplify/collapse.h"
#include "tests/bench/bench_models.h"
#include "tests/bench/fidelity_parts.h"

namespace lode::bench {
namespace {

constexpr size_t kSamples = 500000;  // each way
constexpr double kFirstStep = 0.9, kLadderStep = 0.5;

using test::SampledDistance;

struct Measured {
  double triangles;
  SampledDistance distance;
};

/// Triangle counts to which the whole model is reduced, falling, down to where errors are larger than any of
/// the cuts'.
std::vector<size_t> ladderOf(size_t triangles, size_t fewest) {
  const auto whole = static_cast<double>(triangles);
  std::vector<size_t> ladder{static_cast<size_t>(kFirstStep * whole)};
  for (double count = kLadderStep * whole; count > static_cast<double>(fewest); count *= kLadderStep)
    ladder.push_back(static_cast<size_t>(count));
  return ladder;
}

/// Triangles at which an error is first kept, interpolated in log-log; the whole model's where only it keeps
/// it, nothing where even the fewest do.
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

/// Our own simplifier on the whole model as one node, nothing locked: what the hierarchy alone costs.
std::vector<Measured> measureCollapse(const char* path, const Original& original,
                                      std::span<const size_t> ladder) {
  FileNode node = readNode(path);
  node.mesh.attributes = {};
  node.mesh.wedge_attributes.clear();
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

void compareWith(const char* name, std::span<const Measured> ladder, double whole,
                 std::span<const CutMeasured> cuts) {
  std::printf("triangles of cuts / of %s on the whole model, at equal\n", name);
  for (const bool is_max : {true, false}) {
    double SampledDistance::*const kind = is_max ? &SampledDistance::max : &SampledDistance::rms;
    std::printf("  %-14s", is_max ? "largest error:" : "rms:");
    double logs = 0, count = 0;
    for (const CutMeasured& cut : cuts) {
      const auto theirs = trianglesAt(ladder, whole, cut.measured.distance.*kind, kind);
      if (!theirs) {
        std::printf("  (too coarse)");
        continue;
      }
      std::printf("  %.0f / %.0f = %.2f", cut.measured.triangles, *theirs, cut.measured.triangles / *theirs);
      logs += std::log(cut.measured.triangles / *theirs);
      ++count;
    }
    std::printf("   geometric mean %.2f\n", std::exp(logs / count));
  }
}

}  // namespace

void compareAtEqualError(const char* original, std::span<char* const> paths) {
  const FileSurface surface = readSurface(original);
  const Original measured(surface.soup(), kSamples);
  std::vector<CutMeasured> cuts;
  size_t fewest = surface.triangles.size();
  for (const char* path : paths) {
    const test::TriangleSoup soup = readSurface(path).soup();
    fewest = std::min(fewest, soup.size());
    cuts.push_back({path, {static_cast<double>(soup.size()), measured.distanceOf(soup)}});
    const SampledDistance& distance = cuts.back().measured.distance;
    std::printf("%9zu triangles  largest %.3e  rms %.3e of the diagonal  %s\n", soup.size(), distance.max,
                distance.rms, path);
  }
  const std::vector<size_t> ladder = ladderOf(surface.triangles.size(), fewest / 3);
  const auto whole = static_cast<double>(surface.triangles.size());
  compareWith("meshoptimizer", measureMeshoptimizer(surface, measured, ladder), whole, cuts);
  compareWith("collapse()", measureCollapse(original, measured, ladder), whole, cuts);
}

}  // namespace lode::bench
