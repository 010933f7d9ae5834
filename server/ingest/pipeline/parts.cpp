#include "server/ingest/pipeline/parts.h"

#include <chrono>
#include <string>
#include <utility>

#include "common/error.h"
#include "server/ingest/disk/build_folder.h"
#include "server/ingest/disk/journal.h"
#include "server/ingest/nodes/task_plan.h"
#include "server/ingest/nodes/tree_builder.h"
#include "server/ingest/pipeline/stage_clock.h"
#include "server/ingest/pipeline/treelets_of_build.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/store/reader.h"

namespace lode::ingest {
namespace {

/// Time within which a scheduler repeats a `finish` whose machine is lost.
constexpr auto kRepeatedFinish = std::chrono::hours(1);

/// Reads the journal of the prepared build. @throws Error kInput if this part belongs to another build.
RecordedBuild readPrepared(const BuildOptions& options, const BuildFiles& files) {
  const std::string output = options.output.string();
  std::error_code ignored;
  if (!std::filesystem::exists(files.journal, ignored))
    throw Error(ErrorCode::kIo, output + ": is not prepared; run --part prepare first");
  RecordedBuild recorded;
  Journal::read(files.journal,
                [&](uint32_t kind, std::span<const std::byte> bytes) { recorded.add(kind, bytes); });
  if (!recorded.identity || recorded.tasks == 0)
    throw Error(ErrorCode::kIo, output + ": --part prepare has not finished; run it again");
  const BuildIdentity now = BuildIdentity::of(options);
  for (const FileFingerprint& input : now.inputs)
    if (input.bytes == 0) throw Error(ErrorCode::kIo, input.path + ": cannot be read; restore it");
  const std::string difference = recorded.identity->difference(now, "run --part prepare again");
  if (!difference.empty())
    throw Error(ErrorCode::kInput, "this part does not belong to the build of " + output + ": " + difference);
  if (recorded.tasks != options.tasks)
    throw Error(ErrorCode::kInput, output + ": was prepared for --tasks " + std::to_string(recorded.tasks) +
                                       "; use the same, or run --part prepare again");
  return recorded;
}

}  // namespace

void requirePrepared(const BuildOptions& options) { readPrepared(options, BuildFiles::of(options.output)); }

std::optional<ModelSummary> finishedBefore(const BuildOptions& options) {
  std::error_code error;
  if (std::filesystem::exists(BuildFiles::of(options.output).journal, error) ||
      !std::filesystem::is_regular_file(options.output, error))
    return std::nullopt;
  const auto built = std::filesystem::last_write_time(options.output, error);
  if (error || std::filesystem::file_time_type::clock::now() - built > kRepeatedFinish) return std::nullopt;
  for (const std::filesystem::path& input : inputsOf(options))
    if (std::filesystem::last_write_time(input, error) > built || error) return std::nullopt;
  ModelSummary summary = store::Reader(options.output).summary();
  if (summary.triangles_per_node != options.triangles_per_node) return std::nullopt;
  return summary;
}

BuildReport runTask(const BuildOptions& options, const BuildProgress& progress) {
  const BuildFiles files = BuildFiles::of(options.output);
  const RecordedBuild recorded = readPrepared(options, files);
  if (recorded.isPast(BuildEntry::kSimplified)) {  // only pack is left, which needs no task
    BuildReport finished;
    finished.warnings.push_back(options.output.string() + ": all tasks are finished already");
    return finished;
  }
  RecordReader record(recorded.stages.at(BuildEntry::kPartitioned));
  const auto facts = record.get<BuildFacts>();
  record.getTexts();  // warnings, which `finish` reports
  const TemporaryFolder folder = TemporaryFolder::lasting(files.folder);
  const Partition partition = Partition::load(folder, facts.soup_attributes, record);
  const TreeletsOfBuild work(facts, options, partition);
  const std::vector<uint32_t> task_of = planTasks(work.treelets, options.tasks);
  std::vector<bool> is_wanted(task_of.size());
  for (size_t i = 0; i < task_of.size(); ++i) is_wanted[i] = task_of[i] == options.task;

  BuildReport report;
  StageClock clock(report, "simplify");
  TreeletFolder treelets(files.folder / kTreeletFolder, options.reuse_folder);
  // Without --tmp, `finish` also removes what a killed task leaves.
  const TemporaryFolder scratch(options.scratch_folder.empty() ? files.folder : options.scratch_folder);
  const MemoryPlan plan = planMemory(options.memory_bytes, options.threads, options.triangles_per_node);
  BuiltTree built;
  buildTree(work.settings, partition,
            {.tree = work.tree,
             .treelets = work.treelets,
             .is_wanted = std::move(is_wanted),
             .folder = treelets,
             .scratch = scratch},
            {plan.threads, plan.node_bytes}, progress, built);
  clock.finish(built.size(), built.bytes());
  return report;
}

void requireAllTasks(const BuildOptions& options, const TreeletPlan& treelets, const TreeletFolder& folder) {
  const std::vector<uint32_t> task_of = planTasks(treelets, options.tasks);
  for (uint32_t i = 0; i < treelets.size(); ++i) {
    if (task_of[i] == options.tasks || folder.has(treelets[i].name)) continue;
    throw Error(ErrorCode::kIo, "task " + std::to_string(task_of[i]) + " of " +
                                    std::to_string(options.tasks) + " is not finished; run it again");
  }
}

}  // namespace lode::ingest
