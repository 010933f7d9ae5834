#include "server/ingest/inspect/build_forecast.h"

#include <algorithm>
#include <array>

#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/inspect/texture_forecast.h"
#include "server/ingest/inspect/trial_model.h"
#include "server/ingest/mesh/soup_triangle.h"
#include "server/ingest/pipeline/build.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/ingest/soup/scan.h"
#include "server/sample/sample.h"

namespace lode::ingest {
namespace {

/// Number of triangles in the nodes near the root, which a build simplifies one after another on one thread.
/// Only measuring and encoding use several threads there.
constexpr double kTrianglesOfOneThread = 1e5;
/// Share of the CPU time of the stages `dereference` and `partition` that is spent on one thread. Measured
/// shares range from 0.2 to 0.4.
constexpr double kSerialShare = 0.3;
constexpr uint64_t kTrialTriangles = 400000;
/// Numbers of stretches (runs of consecutive faces) to build the trial model from, tried in this order.
/// Several stretches represent a model better than one, because the cost per triangle varies: a lake is
/// cheaper than a mountain. But if the file lists its faces in long rows, short stretches are thin strips
/// with too many border vertices, and one long stretch is better.
constexpr std::array<uint64_t, 2> kStretches{4, 1};
/// Largest ratio of the trial model's vertices per face to those of the whole model. Border vertices make the
/// ratio larger than 1. Above the limit, consecutive faces of the file are not neighbours on the surface.
constexpr double kMostVerticesOfPart = 1.5;
/// Time and bytes per triangle of a much larger model, relative to the trial model. A large model needs less
/// per triangle, because the upper levels are a smaller share of its tree.
constexpr double kLargeModelShare = 0.85;

/// Cost per triangle, measured by building a trial model.
struct Trial {
  /// CPU time of the stage `pack`, and the serial share of `dereference` and `partition`.
  double serial_cpu_seconds = 0;
  /// CPU time of the stage `simplify`, and the parallel share of `dereference` and `partition`.
  double parallel_cpu_seconds = 0;
  double store_bytes = 0;
};

/// Writes a sample model as the trial model, for a file without coherent stretches; see isCoherent().
void writeStandIn(const ForecastInput& input, const std::filesystem::path& output) {
  SampleOptions sample;
  sample.kind = "asteroid";
  sample.triangles = kTrialTriangles;
  sample.attributes.bits =
      input.attributes.bits & (AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture);
  writeSample(sample, output);
}

/// Returns true if faces share vertices in the part about as often as in the whole model.
bool isCoherent(const TrialModel& part, const ForecastInput& input) {
  return static_cast<double>(part.vertices) * static_cast<double>(input.faces) <=
         kMostVerticesOfPart * static_cast<double>(input.vertices) * static_cast<double>(part.faces);
}

Trial runTrial(const ForecastInput& input) {
  const TemporaryFolder folder(input.temporary_folder);
  BuildOptions options;
  options.input = folder.path() / "trial.ply";
  options.output = folder.path() / "trial.lode";
  options.temporary_folder = folder.path();
  options.threads = input.threads;
  const uint64_t faces = input.triangles <= kTrialTriangles
                             ? input.faces
                             : std::max<uint64_t>(1, input.faces * kTrialTriangles / input.triangles);
  const bool is_part = std::any_of(kStretches.begin(), kStretches.end(), [&](uint64_t stretches) {
    return isCoherent(
        writeTrialModel(input.model, input.faces, faces, std::min(stretches, faces), options.input), input);
  });
  if (!is_part) writeStandIn(input, options.input);
  const BuildReport report = build(options);
  const auto triangles = static_cast<double>(report.summary.triangles + report.summary.dropped);
  Trial trial;
  for (const BuildReport::Stage& stage : report.stages) {
    if (stage.name == "scan") continue;
    const double serial = stage.name == "pack" ? 1 : stage.name == "simplify" ? 0 : kSerialShare;
    trial.serial_cpu_seconds += serial * stage.cpu_seconds / triangles;
    trial.parallel_cpu_seconds += (1 - serial) * stage.cpu_seconds / triangles;
  }
  trial.store_bytes = static_cast<double>(report.summary.bytes) / triangles;
  return trial;
}

/// Returns the peak size of the temporary files. It is the largest of three sums: packed input plus sorted
/// runs; leaves plus the runs or packed input they are made from; leaves plus payloads.
uint64_t temporaryBytes(const ForecastInput& input, uint64_t sort_bytes, uint64_t payload_bytes) {
  const uint64_t vertex_bytes =
      packedVertexBytes(vertexAttributes(input.attributes, input.face_attributes), input.double_positions);
  const bool only_triangles = input.faces == input.triangles;
  const uint64_t packed =
      input.vertices * vertex_bytes +
      (input.triangles + 2 * input.faces) *
          (sizeof(uint32_t) + (input.face_attributes.has(AttributeSet::kTexture) ? sizeof(glm::vec2) : 0)) +
      (input.attributes.has(AttributeSet::kMaterial) ? input.faces * sizeof(uint16_t) : 0) +
      (input.face_attributes.has(AttributeSet::kColour) ? input.faces * sizeof(glm::u8vec4) : 0) +
      (only_triangles ? 0 : input.faces * sizeof(uint32_t));
  const uint64_t runs = input.triangles * (soupBytes(input.attributes) + sizeof(uint64_t));
  const uint64_t wedge_bytes = input.attributes.bits == 0 ? 0 : sizeof(uint32_t) + sizeof(VertexAttributes);
  const bool may_have_many_wedges = input.face_attributes.has(AttributeSet::kTexture | AttributeSet::kColour);
  const uint64_t leaves = input.triangles * sizeof(glm::u32vec3) + input.vertices * sizeof(PositionCode) +
                          (may_have_many_wedges ? 3 * input.triangles : input.vertices) * wedge_bytes;
  const bool sorts_on_disk = runs + input.triangles * sizeof(uint64_t) > sort_bytes;
  return std::max({packed + (sorts_on_disk ? runs : 0), leaves + (sorts_on_disk ? runs : packed),
                   leaves + payload_bytes});
}

}  // namespace

BuildForecast forecastBuild(const ForecastInput& input) {
  const Trial trial = runTrial(input);
  const TextureForecast textures = forecastTextures(input.images, input.memory_bytes, input.threads);
  const bool is_large = input.triangles > 2 * kTrialTriangles;
  const double triangles = static_cast<double>(input.triangles) * (is_large ? kLargeModelShare : 1);
  const double serial =
      input.scan_cpu_seconds + textures.serial_cpu_seconds + trial.serial_cpu_seconds * triangles;
  const double alone = trial.parallel_cpu_seconds * std::min(triangles, kTrianglesOfOneThread);
  const double parallel = textures.parallel_cpu_seconds + trial.parallel_cpu_seconds * triangles;
  const auto payload_bytes = static_cast<uint64_t>(trial.store_bytes * triangles);
  BuildForecast forecast;
  forecast.cpu_seconds = serial + parallel;
  forecast.seconds = serial + alone + (parallel - alone) / input.threads;
  forecast.store_bytes = payload_bytes + textures.tile_bytes;
  const uint32_t triangles_per_node = BuildOptions().triangles_per_node;
  const MemoryPlan plan = planMemory(input.memory_bytes, input.threads, triangles_per_node);
  forecast.temporary_bytes = temporaryBytes(input, plan.sort_bytes, payload_bytes) + textures.tile_bytes;
  forecast.memory_bytes = expectedPeakBytes(plan, input.vertices, input.triangles, input.attributes,
                                            triangles_per_node, textures.memory_bytes);
  return forecast;
}

}  // namespace lode::ingest
