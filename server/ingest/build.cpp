#include "server/ingest/build.h"

#include <algorithm>
#include <chrono>

#include "common/error.h"
#include "server/ingest/cell_code.h"
#include "server/ingest/dereference.h"
#include "server/ingest/lattice_choice.h"
#include "server/ingest/machine.h"
#include "server/ingest/memory_plan.h"
#include "server/ingest/pack.h"
#include "server/ingest/partition.h"
#include "server/ingest/scan.h"
#include "server/ingest/simplify.h"
#include "server/ingest/textures.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kMinTrianglesPerNode = 64;

/// Notes time, memory and disk of a stage from construction to finish().
class StageClock {
 public:
  StageClock(BuildReport& report, std::string name) : report_(report), name_(std::move(name)) {}

  void finish(uint64_t items, uint64_t temporary_bytes) {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start_;
    report_.stages.push_back(
        {name_, wall.count(), cpuSeconds() - cpu_start_, items, temporary_bytes, peakRssBytes()});
    report_.seconds += report_.stages.back().seconds;
    report_.cpu_seconds += report_.stages.back().cpu_seconds;
    report_.peak_rss_bytes = peakRssBytes();
  }

 private:
  BuildReport& report_;
  const std::string name_;
  const std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  const double cpu_start_ = cpuSeconds();
};

BuildOptions withDefaults(BuildOptions options) {
  if (options.memory_bytes == 0) options.memory_bytes = defaultMemoryBytes();
  if (options.threads == 0) options.threads = defaultThreads();
  if (options.temporary_folder.empty()) {
    options.temporary_folder = options.output.has_parent_path() ? options.output.parent_path() : ".";
  }
  if (options.triangles_per_node < kMinTrianglesPerNode) {
    throw Error(ErrorCode::kUsage,
                "--triangles-per-node must be at least " + std::to_string(kMinTrianglesPerNode));
  }
  return options;
}

/// Attributes of the payloads: the file's, with computed normals where it has none.
AttributeSet payloadAttributes(AttributeSet file) {
  if (!file.has(AttributeSet::kNormal)) file.bits |= AttributeSet::kNormal | AttributeSet::kComputedNormal;
  return file;
}

void refuseWarnings(const BuildOptions& options, const BuildReport& report) {
  if (options.strict && !report.warnings.empty())
    throw Error(ErrorCode::kInput, report.warnings.front() + " (--strict: warnings are errors)");
}

/// The images of a model with texture coordinates.
StagedTextures readTextures(const BuildOptions& options, const ScannedModel& scanned, Spool& tiles,
                            const BuildProgress& progress, BuildReport& report) {
  if (scanned.texture_files.empty()) return {scanned.input.uvGrid(), {}};
  if (!scanned.input.attributes().has(AttributeSet::kTexture)) {
    report.warnings.push_back(options.input.string() +
                              ": it names texture files, but has no texture coordinates; they are left out");
    return {};
  }
  StageClock clock(report, "textures");
  StagedTextures textures = stageTextures(options, scanned.texture_files, scanned.input.uvGrid(), tiles,
                                          options.memory_bytes, progress, report.warnings);
  giveBackFreedMemory();
  clock.finish(textures.textures.size(), tiles.size());
  return textures;
}

}  // namespace

BuildReport build(const BuildOptions& given, const BuildProgress& progress) {
  const BuildOptions options = withDefaults(given);
  BuildReport report;
  const TemporaryFolder folder(options.temporary_folder);
  const MemoryPlan plan = planMemory(options.memory_bytes, options.threads, options.triangles_per_node);

  StageClock scan_clock(report, "scan");
  auto scanned = std::make_unique<ScannedModel>(scan(options, folder, progress, report.warnings));
  const LatticeChoice choice = chooseLattice(scanned->input, options.input);
  const AttributeSet soup_attributes = scanned->input.attributes();
  scan_clock.finish(scanned->input.vertexCount() + scanned->input.faceCount(),
                    scanned->input.temporaryBytes());

  Spool tiles(folder.file("tiles"));
  const StagedTextures textures = readTextures(options, *scanned, tiles, progress, report);
  refuseWarnings(options, report);

  StageClock dereference_clock(report, "dereference");
  auto sorter = std::make_unique<RecordSorter>(soupBytes(soup_attributes), plan.sort_bytes, folder, "soup");
  const CellGrid grid(choice.extent);
  std::byte record[kMaxSoupBytes];
  const DereferenceCounts counts = dereference(
      scanned->input, choice.lattice, plan.sort_bytes,
      [&](const SoupTriangle& triangle) {
        const std::span<std::byte> bytes(record, soupBytes(soup_attributes));
        storeSoup(triangle, bytes);
        sorter->push(grid.code(triangle), bytes);
      },
      progress);
  if (counts.triangles == 0) {
    throw Error(ErrorCode::kInput,
                options.input.string() + ": no face has three distinct corners; check the file");
  }
  const uint64_t dropped = counts.dropped + scanned->counts.dropped_faces + scanned->counts.skipped_bad;
  scanned.reset();
  sorter->finish();
  dereference_clock.finish(counts.triangles, sorter->temporaryBytes());

  StageClock partition_clock(report, "partition");
  const Partition parts =
      partition(*sorter, soup_attributes, options.triangles_per_node, plan.sort_bytes, folder, progress);
  sorter.reset();
  giveBackFreedMemory();
  partition_clock.finish(parts.triangleCount(), parts.soup.size() + parts.border.temporaryBytes());

  if (parts.leaves.size() > 1 && options.memory_bytes < plan.minimum_bytes) {
    report.warnings.push_back("--memory is less than " + std::to_string(plan.minimum_bytes) +
                              " bytes, which " + std::to_string(options.triangles_per_node) +
                              " triangles a node take; the build may use more");
    refuseWarnings(options, report);
  }
  StageClock simplify_clock(report, "simplify");
  PayloadSpool payloads(folder);
  const NodeBuilder::Settings settings{choice.lattice, choice.extent, payloadAttributes(soup_attributes),
                                       options.triangles_per_node, options.simplifier};
  SimplifiedTree tree = simplify(settings, parts, payloads, plan.threads, progress);
  simplify_clock.finish(tree.nodes.size(), payloads.size());

  StageClock pack_clock(report, "pack");
  ModelSummary summary;
  summary.name = options.output.stem().string();
  summary.lattice = choice.lattice;
  summary.attributes = settings.attributes;
  summary.triangles = counts.triangles;
  summary.dropped = dropped;
  summary.triangles_per_node = options.triangles_per_node;
  for (const Node& node : tree.nodes) {
    if (node.key == kRootKey) summary.box = node.box;
  }
  store::Writer writer(options.output);
  if (settings.attributes.has(AttributeSet::kTexture)) packTextures(textures, tiles, writer);
  report.summary = pack(writer, std::move(summary), std::move(tree), payloads, progress);
  pack_clock.finish(report.summary.payloads, 0);
  return report;
}

}  // namespace lode::ingest
