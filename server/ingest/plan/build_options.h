#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/codec/model_summary.h"
#include "server/ingest/plan/simplifier.h"

namespace lode::ingest {

constexpr uint32_t kMinTrianglesPerNode = 64;

/// What a build is asked for.
struct BuildOptions {
  std::filesystem::path input, output;
  std::filesystem::path temporary_folder;  ///< for temporary files; empty: the output's folder
  uint64_t memory_bytes = 0;               ///< 0: defaultMemoryBytes()
  unsigned threads = 0;                    ///< 0: one a core
  uint32_t triangles_per_node = 16384;
  Simplifier simplifier = Simplifier::kCollapse;
  /// Computed normals are smooth where faces meet at less. The default keeps chamfers of 45 degrees sharp and
  /// bores of nine sides round; see docs/decisions/0023-crease-angle.md.
  float crease_angle_deg = 44;
  /// Bad indices and coordinates are dropped and counted, bad attributes set to zero and counted apart, not
  /// an error.
  bool skip_bad = false;
  bool strict = false;  ///< warnings are errors
  /// Go on where a build of the same input, output and options ended that was killed or failed, and keep what
  /// is there if this one fails for a reason that is not in the input.
  bool resume = false;
};

/// What a build has done.
struct BuildReport {
  struct Stage {
    std::string name;
    double seconds = 0, cpu_seconds = 0;
    uint64_t items = 0;            ///< vertices and faces, triangles, nodes: what the stage counts
    uint64_t temporary_bytes = 0;  ///< written to temporary files during the stage
    uint64_t peak_rss_bytes = 0;   ///< of the process, at the stage's end
  };
  ModelSummary summary;
  std::vector<Stage> stages;  ///< those of this run
  std::string resumed_from;   ///< the stage with which this run went on; empty: it began at the beginning
  std::vector<std::string> warnings;
  std::vector<std::string> texture_files;  ///< that the file names and has coordinates for, found or not
  uint64_t peak_rss_bytes = 0;
  double seconds = 0, cpu_seconds = 0;
};

/// Called from the building thread a few times a second: fraction of the stage that is done, and its items.
/// What it throws ends the build, as any failure does.
using BuildProgress =
    std::function<void(std::string_view stage, double fraction, uint64_t done, uint64_t total)>;

}  // namespace lode::ingest
