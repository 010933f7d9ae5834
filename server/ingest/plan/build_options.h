#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/codec/model_summary.h"
#include "common/limits.h"

namespace lode::ingest {

constexpr uint32_t kMinTrianglesPerNode = 64;

/// Algorithm that makes the LODs of a node.
enum class Simplifier : uint8_t {
  kCollapse,  ///< collapse(): fewest triangles for an error
  kCluster,   ///< cluster(): a fast preview; the method of the 2005 paper
};
constexpr std::string_view nameOf(Simplifier simplifier) noexcept {
  return simplifier == Simplifier::kCluster ? "cluster" : "collapse";
}

/// Options that change the store or decide whether the build succeeds. A build resumes only with the same
/// values. To add one, add its member and its line in forEachResultOption(): the command line of `build`,
/// the journal and the check of --resume follow from that line.
struct ResultOptions {
  uint32_t triangles_per_node = 16384;
  Simplifier simplifier = Simplifier::kCollapse;
  /// Computed normals are smooth across an edge if its faces meet at a smaller angle. The default keeps
  /// chamfers of 45 degrees sharp and bores of nine sides round.
  float crease_angle_deg = 44;
  /// Drop and count bad indices and coordinates, set bad attributes to zero and count them; else an error.
  bool skip_bad = false;
  bool strict = false;  ///< warnings are errors
};

/// Declaration of one result option.
template <class Value>
struct ResultOption {
  const char* name;  ///< on the command line
  Value ResultOptions::*member;
  const char* help;
  Value least{}, most{};       ///< range of a number
  const char* unit = nullptr;  ///< of a number, as help texts show it
};

/// Calls visit(ResultOption<Value>) for each result option.
template <class Visit>
void forEachResultOption(Visit&& visit) {
  visit(ResultOption<uint32_t>{"--triangles-per-node", &ResultOptions::triangles_per_node,
                               "split nodes with more triangles", kMinTrianglesPerNode, kMaxLodTriangles});
  visit(ResultOption<Simplifier>{
      "--simplifier", &ResultOptions::simplifier,
      "how to simplify nodes: collapse, or cluster for a fast preview (default: collapse)"});
  visit(ResultOption<float>{"--crease-angle", &ResultOptions::crease_angle_deg,
                            "if the file has no normals: edges are sharp where faces meet at a larger angle; "
                            "180: no sharp edges",
                            0, 180, "DEGREES"});
  visit(ResultOption<bool>{"--skip-bad", &ResultOptions::skip_bad,
                           "drop and count bad indices and coordinates; set NaN or infinite colours, normals "
                           "and texture coordinates of vertices to 0 and count them separately"});
  visit(ResultOption<bool>{"--strict", &ResultOptions::strict, "treat warnings as errors"});
}

struct BuildOptions : ResultOptions {
  std::filesystem::path input, output;
  std::filesystem::path temporary_folder;  ///< empty: the output's folder
  uint64_t memory_bytes = 0;               ///< 0: defaultMemoryBytes()
  unsigned threads = 0;                    ///< 0: one per core
  /// Continue a build of the same input, output and options that was killed or failed. If this build fails
  /// for a reason outside its input, keep its finished work.
  bool resume = false;
};

struct BuildReport {
  struct Stage {
    std::string name;
    double seconds = 0, cpu_seconds = 0;
    uint64_t items = 0;            ///< the stage's unit: vertices and faces, triangles, or nodes
    uint64_t temporary_bytes = 0;  ///< written to temporary files by the stage
    uint64_t peak_rss_bytes = 0;   ///< of the process until the stage's end
  };
  ModelSummary summary;
  std::vector<Stage> stages;  ///< stages that this run executed
  std::string resumed_from;   ///< first stage that a resumed build executed; empty: not resumed
  std::vector<std::string> warnings;
  std::vector<std::string> texture_files;  ///< named by an input with texture coordinates, found or not
  uint64_t peak_rss_bytes = 0;
  double seconds = 0, cpu_seconds = 0;
};

/// Reports progress within a stage. Called by the building thread a few times a second; an exception that it
/// throws ends the build.
using BuildProgress =
    std::function<void(std::string_view stage, double fraction, uint64_t done, uint64_t total)>;

}  // namespace lode::ingest
