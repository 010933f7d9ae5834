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
  kCollapse,  ///< collapse(): edge collapse, which needs the fewest triangles for a given error
  kCluster,   ///< cluster(): vertex clustering as in the 2005 paper, for a fast preview
};
constexpr std::string_view nameOf(Simplifier simplifier) noexcept {
  return simplifier == Simplifier::kCluster ? "cluster" : "collapse";
}

/// Options that change the store or decide whether the build succeeds. A build resumes only with the same
/// values. To add an option, add its member here and its line in forEachResultOption(). The command line of
/// `build`, the journal and the check of --resume follow from that line.
struct ResultOptions {
  uint32_t triangles_per_node = 16384;
  Simplifier simplifier = Simplifier::kCollapse;
  /// Crease angle. Computed normals are smooth across an edge if the normals of its two faces differ by less
  /// than this angle. With the default, chamfers of 45 degrees stay sharp, and nine-sided bores look round.
  float crease_angle_deg = 44;
  /// Distance between neighbouring lattice points, rounded down to a valid one (see isLatticeStep()); 0:
  /// follows from the lengths of edges.
  float step_model = 0;
  /// If true, drops faces and vertices with bad indices or coordinates, sets bad attributes to zero, and
  /// counts both. If false, such input fails the build.
  bool skip_bad = false;
  bool strict = false;  ///< true treats warnings as errors
};

/// Describes one member of ResultOptions as a command-line option.
template <class Value>
struct ResultOption {
  const char* name;  ///< name on the command line
  Value ResultOptions::*member;
  const char* help;
  Value least{}, most{};       ///< allowed range of a numeric option
  const char* unit = nullptr;  ///< unit of a numeric option, shown in help texts
};

/// Calls visit(ResultOption<Value>) for each member of ResultOptions.
template <class Visit>
void forEachResultOption(Visit&& visit) {
  visit(ResultOption<uint32_t>{"--triangles-per-node", &ResultOptions::triangles_per_node,
                               "node capacity: a node with more triangles is split", kMinTrianglesPerNode,
                               kMaxLodTriangles});
  visit(ResultOption<Simplifier>{
      "--simplifier", &ResultOptions::simplifier,
      "how to simplify nodes: collapse, or cluster for a fast preview (default: collapse)"});
  visit(ResultOption<float>{
      "--crease-angle", &ResultOptions::crease_angle_deg,
      "if the file has no normals: an edge is sharp if its faces meet at a larger angle; 180: no sharp edges",
      0, 180, "DEGREES"});
  visit(
      ResultOption<float>{"--step", &ResultOptions::step_model,
                          "round coordinates to multiples of this length, or of the next smaller valid one, "
                          "so that separately built neighbours meet; 0: choose by the lengths of edges",
                          0, 1e18F, "LENGTH"});
  visit(ResultOption<bool>{"--skip-bad", &ResultOptions::skip_bad,
                           "drop faces and vertices with bad indices or coordinates, set NaN and infinite "
                           "attributes to 0, and count both"});
  visit(ResultOption<bool>{"--strict", &ResultOptions::strict, "treat warnings as errors"});
}

/// Part of a build whose simplification is divided into tasks for several machines; see docs/cluster.md.
enum class BuildPart : uint8_t {
  kWhole,     ///< the whole build, in one process
  kPrepare,   ///< all stages before simplify
  kSimplify,  ///< one task of simplify; needs kPrepare
  kFinish,    ///< the rest of simplify, and pack; needs all tasks
};

constexpr uint32_t kMaxTasks = 1 << 16;

struct BuildOptions : ResultOptions {
  std::filesystem::path input, output;
  /// More PLY files of the same model, whose triangles follow those of `input`. All files must have the same
  /// attributes.
  std::vector<std::filesystem::path> more_inputs;
  std::filesystem::path preview;  ///< store to write as soon as the input is read; empty: none
  /// Folder to search first for the images that the input names; empty: only the input's folder. The images
  /// are part of the build's identity (BuildIdentity), but the folder is not.
  std::filesystem::path textures_folder;
  /// Parent of the temporary files; empty: the output's folder. A build in parts keeps the files that its
  /// parts share in the output's folder.
  std::filesystem::path temporary_folder;
  std::filesystem::path scratch_folder;  ///< parent of the files of a single task; set by build()
  uint64_t memory_bytes = 0;             ///< memory budget; 0: defaultMemoryBytes()
  unsigned threads = 0;                  ///< number of threads; 0: one per core
  /// True continues a killed or failed build of the same input, output and options. If this build fails for
  /// lack of memory or through an I/O error, it keeps its own finished work, too.
  bool resume = false;
  /// With `resume`: starts from the beginning, instead of failing, if the earlier build had another input or
  /// other options, or if its journal is damaged.
  bool restart_if_changed = false;
  BuildPart part = BuildPart::kWhole;
  uint32_t tasks = 0;  ///< number of tasks, the same in all parts
  uint32_t task = 0;   ///< number of the task to run, with BuildPart::kSimplify
  /// Folder of finished treelets (see TreeletFolder) that builds share; empty: none.
  std::filesystem::path reuse_folder;
  /// Store on whose lattice to build; empty: the lattice follows from the input. With `reuse_folder`, the
  /// store at `output` counts, if its lattice suits.
  std::filesystem::path lattice_of;
  uint64_t reuse_bytes = 0;  ///< size to which the build trims `reuse_folder`; 0: kReuseBytes
};

/// Returns all input files, in the order of their triangles.
inline std::vector<std::filesystem::path> inputsOf(const BuildOptions& options) {
  std::vector<std::filesystem::path> inputs{options.input};
  inputs.insert(inputs.end(), options.more_inputs.begin(), options.more_inputs.end());
  return inputs;
}

constexpr uint64_t kReuseBytes = 16ull << 30;

struct BuildReport {
  struct Stage {
    std::string name;
    double seconds = 0, cpu_seconds = 0;
    /// Number of vertices and faces, textures, triangles, nodes or payloads, depending on the stage.
    uint64_t items = 0;
    uint64_t temporary_bytes = 0;  ///< bytes that the stage wrote to temporary files
    uint64_t peak_rss_bytes = 0;   ///< peak memory of the process until the stage's end
  };
  ModelSummary summary;
  std::vector<Stage> stages;  ///< stages that this run executed
  std::string resumed_from;   ///< first stage executed after resuming a build; empty if none was resumed
  std::vector<std::string> warnings;
  /// Names of the texture images in the input's header, even of missing images; empty if the input has no
  /// texture coordinates.
  std::vector<std::string> texture_files;
  uint64_t peak_rss_bytes = 0;
  double seconds = 0, cpu_seconds = 0;
};

/// Stage that BuildProgress reports once BuildOptions::preview is written.
constexpr std::string_view kPreviewStage = "preview";

/// Receives progress within a stage. The thread that called build() calls this function, usually several
/// times a second. An exception that the function throws ends the build.
using BuildProgress =
    std::function<void(std::string_view stage, double fraction, uint64_t done, uint64_t total)>;

}  // namespace lode::ingest
