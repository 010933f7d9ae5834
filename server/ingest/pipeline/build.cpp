#include "server/ingest/pipeline/build.h"

#include <array>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/io/output_target.h"
#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/pipeline/parts.h"
#include "server/ingest/pipeline/stages.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/ingest/preview/preview.h"
#include "server/ingest/soup/scan.h"

namespace lode::ingest {
namespace {

/// Returns an output's path with symbolic links resolved, so that temporary files lie beside the real file.
std::filesystem::path outputOf(const std::filesystem::path& path) {
  OutputTarget target = findOutput(path);
  if (target.is_stream)
    throw Error(ErrorCode::kUsage,
                path.string() + ": is a pipe or a device; a store must be a file: name another output");
  return std::move(target.path);
}

BuildOptions withDefaults(BuildOptions options) {
  options.output = outputOf(options.output);
  if (!options.preview.empty()) options.preview = outputOf(options.preview);
  if (options.memory_bytes == 0) options.memory_bytes = defaultMemoryBytes();
  if (options.threads == 0) options.threads = defaultThreads();
  const std::filesystem::path beside = options.output.has_parent_path() ? options.output.parent_path() : ".";
  options.scratch_folder = options.temporary_folder;
  if (options.temporary_folder.empty()) options.temporary_folder = beside;
  if (options.part != BuildPart::kWhole) {
    options.temporary_folder = beside;
    options.resume = true;
    options.restart_if_changed = options.part == BuildPart::kPrepare;
  }
  if (options.reuse_bytes == 0) options.reuse_bytes = kReuseBytes;
  if (options.triangles_per_node < kMinTrianglesPerNode) {
    throw Error(ErrorCode::kUsage,
                "--triangles-per-node must be at least " + std::to_string(kMinTrianglesPerNode));
  }
  return options;
}

/// Runs the stages in order. The constructor of a stage receives the stages whose results it needs.
void runStages(BuildSession& session) {
  ScanStage scan(session);
  TextureStage textures(session, scan);
  DereferenceStage dereference(session, scan);
  PartitionStage partition(session, dereference);
  SimplifyStage simplify(session, partition);
  PackStage pack(session, textures, simplify);
  const std::array<Stage*, 6> in_order{&scan, &textures, &dereference, &partition, &simplify, &pack};
  for (Stage* stage : in_order) {
    if (stage == &simplify && session.options().part == BuildPart::kPrepare) return session.noteTasks();
    session.run(*stage);
    if (stage == &scan) scan.writePreview();
  }
  for (const NamedImage& image : scan.namedImages()) session.noteTextureFile(image.name);
}

/// Returns a hint on how to resume after a failure, or an empty string if a resumed build would fail in the
/// same way.
std::string_view resumeHint(const Error& error, const BuildSession& session) noexcept {
  if (error.code() == ErrorCode::kIo) return "run the same command again to continue";
  if (session.options().part == BuildPart::kFinish)
    return "correct the fault, and run the same command again";
  return session.lacksMemory() ? "run the same command with more --memory to continue" : "";
}

BuildReport reportOf(const ModelSummary& finished, const BuildOptions& options) {
  BuildReport report;
  report.summary = finished;
  report.warnings.push_back(options.output.string() + ": is finished already");
  return report;
}

}  // namespace

void buildPreview(const BuildOptions& options, std::vector<std::string>& warnings,
                  const BuildProgress& progress) {
  const uint64_t memory_bytes = options.memory_bytes > 0 ? options.memory_bytes : defaultMemoryBytes();
  const std::filesystem::path target = outputOf(options.preview);
  const std::filesystem::path parent = target.has_parent_path() ? target.parent_path() : ".";
  const TemporaryFolder folder(options.temporary_folder.empty() ? parent : options.temporary_folder);
  const ScannedModel model = scan(options, folder, progress, warnings);
  if (options.strict && !warnings.empty())
    throw Error(ErrorCode::kInput, warnings.front() + " (a warning, and --strict is set)");
  const uint64_t needed_bytes = previewBytes(model.input);
  if (needed_bytes > memory_bytes)
    throw Error(ErrorCode::kLimit, budgetBelowInWords(needed_bytes, "a preview of this file"));
  TextureColours textures;
  if (model.input.attributes().has(AttributeSet::kTexture)) {
    const uint64_t image_bytes = memory_bytes / 2;
    textures = {surveyTextures(model.images, options.textures_folder, image_bytes), model.input.uvGrid(),
                image_bytes};
  }
  if (!writePreview(target, model.input, chooseLattice(model.input, options.input), textures))
    throw Error(ErrorCode::kInput,
                options.input.string() +
                    ": no triangle has three different corners; export the model again, with its faces");
}

BuildReport build(const BuildOptions& given, const BuildProgress& progress) {
  const BuildOptions options = withDefaults(given);
  shareHeaps(options.memory_bytes);
  if (options.part == BuildPart::kSimplify) return runTask(options, progress);
  if (options.part == BuildPart::kFinish) {
    if (const std::optional<ModelSummary> finished = finishedBefore(options))
      return reportOf(*finished, options);
    requirePrepared(options);
  }
  BuildSession session(options, progress);
  try {
    if (given.output.extension() != ".lode")
      session.warn(given.output.string() +
                   ": serve finds stores in a folder only if their names end in .lode");
    runStages(session);
    return session.takeReport();
  } catch (const Error& error) {
    const std::string_view hint = resumeHint(error, session);
    if (!options.resume || hint.empty() || !session.keep()) throw;
    throw Error(error.code(), std::string(error.what()) + "; finished work is kept, " + std::string(hint));
  } catch (const std::exception&) {
    if (options.resume) session.keep();
    throw;
  }
}

}  // namespace lode::ingest
