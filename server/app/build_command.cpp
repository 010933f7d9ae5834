#include <algorithm>
#include <csignal>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <unistd.h>

#include "common/byte_size.h"
#include "common/command_line.h"
#include "common/io/copied_input.h"
#include "common/io/texture_finder.h"
#include "common/printable.h"
#include "server/app/command.h"
#include "server/app/input_list.h"
#include "server/app/interruption.h"
#include "server/app/json_output.h"
#include "server/app/progress_bar.h"
#include "server/ingest/pipeline/build.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/ply/ply_header.h"
#include "server/store/reader.h"

namespace lode::app {
namespace {

struct BuildArguments {
  ingest::BuildOptions options;
  std::vector<std::string> inputs;  ///< words that name the input; see listInputs()
  bool json = false, quiet = false, json_progress = false;
};

/// Returns true if a part of a build writes no store.
bool isWithoutStore(ingest::BuildPart part) {
  return part == ingest::BuildPart::kPrepare || part == ingest::BuildPart::kSimplify;
}

Json describeAsJson(const ingest::BuildReport& report, ingest::BuildPart part) {
  Json json = isWithoutStore(part) ? Json::object() : toJson(report.summary);
  json["seconds"] = report.seconds;
  json["cpu_seconds"] = report.cpu_seconds;
  json["peak_rss_bytes"] = report.peak_rss_bytes;
  json["stages"] = Json::array();
  for (const ingest::BuildReport::Stage& stage : report.stages)
    json["stages"].push_back({{"name", stage.name},
                              {"seconds", stage.seconds},
                              {"cpu_seconds", stage.cpu_seconds},
                              {"items", stage.items},
                              {"temporary_bytes", stage.temporary_bytes},
                              {"peak_rss_bytes", stage.peak_rss_bytes}});
  json["resumed_from"] = report.resumed_from.empty() ? Json(nullptr) : Json(report.resumed_from);
  json["warnings"] = report.warnings;
  json["texture_files"] = report.texture_files;
  return json;
}

std::string describe(const ingest::BuildReport& report, const ingest::BuildOptions& options) {
  const ModelSummary& summary = report.summary;
  if (isWithoutStore(options.part)) {
    char numbers[96];
    std::snprintf(numbers, sizeof numbers, "%.1f s, %.1f CPU s, peak memory ", report.seconds,
                  report.cpu_seconds);
    const std::string part =
        options.part == ingest::BuildPart::kPrepare
            ? "prepared for " + counted(options.tasks, "task")
            : "finished task " + std::to_string(options.task) + " of " + std::to_string(options.tasks);
    return options.output.string() + ": " + part + "; " + numbers + describeBytes(report.peak_rss_bytes) +
           "\n";
  }
  char numbers[160];
  std::snprintf(
      numbers, sizeof numbers, "%.1f s, %.1f CPU s, %.2f M triangles a CPU second, peak memory ",
      report.seconds, report.cpu_seconds,
      report.cpu_seconds > 0 ? static_cast<double>(summary.triangles) / report.cpu_seconds / 1e6 : 0.0);
  return options.output.string() + ": " + counted(summary.triangles, "triangle") + " in " +
         counted(summary.nodes, "node") + ", " + describeBytes(summary.bytes) +
         (summary.dropped > 0 ? ", " + counted(summary.dropped, "flat or bad triangle") + " dropped" : "") +
         "; " + numbers + describeBytes(report.peak_rss_bytes) + "\n";
}

/// Checks an output path. @throws Error kUsage if the build would overwrite one of its input files.
void checkOutput(const ingest::BuildOptions& options, const std::filesystem::path& output) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(output, ignored)) return;
  const auto refuseIf = [&](const std::filesystem::path& read, const char* what) {
    if (std::filesystem::equivalent(read, output, ignored))
      throw Error(ErrorCode::kUsage, output.string() + " is " + what + "; name another output");
  };
  for (const std::filesystem::path& input : ingest::inputsOf(options)) {
    refuseIf(input, "the input itself");
    TextureFinder finder(input, options.textures_folder);
    for (const std::string& name : ingest::readPlyHeader(input).texture_files)
      refuseIf(finder.find(name).path, "a texture image of the input");
  }
}

/// Checks the path of a preview that a build writes beside its output. @throws Error kUsage.
void checkPreview(const ingest::BuildOptions& options) {
  checkOutput(options, options.preview);
  if (std::filesystem::weakly_canonical(options.preview) == std::filesystem::weakly_canonical(options.output))
    throw Error(ErrorCode::kUsage, options.preview.string() + ": is the output itself; name another preview");
}

ingest::BuildReport buildUnlessInterrupted(const BuildArguments& arguments) {
  const bool is_kept = arguments.options.resume || arguments.options.part != ingest::BuildPart::kWhole;
  const Interruption interruption(
      is_kept ? "interrupted" : "interrupted; nothing was written, start it again",
      is_kept ? "; finished work is kept, run the same command again to continue" : "");
  try {
    const unsigned threads =
        arguments.options.threads > 0 ? arguments.options.threads : ingest::defaultThreads();
    const ingest::BuildEstimate estimate(threads);
    ProgressBar bar = arguments.json_progress
                          ? ProgressBar(stdout, ProgressBar::Mode::kJson, estimate)
                          : ProgressBar(stderr, ProgressBar::modeFor(stderr, arguments.quiet), estimate);
    const auto onProgress = [&](std::string_view stage, double fraction, uint64_t done, uint64_t total) {
      interruption.check();
      bar.update(stage, fraction, done, total);
    };
    ingest::BuildReport report = ingest::build(arguments.options, onProgress);
    bar.finish();
    return report;
  } catch (const Error& error) {
    interruption.endProcessIfReceived(error.what());
    throw;
  }
}

template <class Value>
void addResultOption(CLI::App& command, const ingest::ResultOption<Value>& option,
                     ingest::ResultOptions& options) {
  Value& value = options.*option.member;
  if constexpr (std::is_same_v<Value, bool>) {
    command.add_flag(option.name, value, option.help);
  } else if constexpr (std::is_same_v<Value, ingest::Simplifier>) {
    const auto set = [&value](const std::string& name) {
      value = name == nameOf(ingest::Simplifier::kCluster) ? ingest::Simplifier::kCluster
                                                           : ingest::Simplifier::kCollapse;
    };
    command.add_option_function<std::string>(option.name, set, option.help)
        ->check(CLI::IsMember({std::string(nameOf(ingest::Simplifier::kCollapse)),
                               std::string(nameOf(ingest::Simplifier::kCluster))}));
  } else {
    CLI::Option* const added = command.add_option(option.name, value, option.help);
    if constexpr (std::is_floating_point_v<Value>)
      added->check(numberFrom(option.least, option.most));
    else
      added->check(CLI::Range(option.least, option.most));
    if (option.unit != nullptr) added->type_name(option.unit);
    added->capture_default_str();
  }
}

void printWarnings(std::span<const std::string> warnings) {
  for (const std::string& warning : warnings)
    std::fprintf(stderr, "lodestreamd: warning: %s\n", warning.c_str());
}

/// Writes only the preview.
void runPreview(const BuildArguments& arguments) {
  const ingest::BuildOptions& options = arguments.options;
  checkOutput(options, options.preview);
  const Interruption interruption("interrupted; nothing was written, start it again", "");
  std::vector<std::string> warnings;
  try {
    ingest::buildPreview(options, warnings,
                         [&](std::string_view, double, uint64_t, uint64_t) { interruption.check(); });
  } catch (const Error& error) {
    interruption.endProcessIfReceived(error.what());
    throw;
  }
  printWarnings(warnings);
  const ModelSummary summary = store::Reader(options.preview).summary();
  if (arguments.json) {
    Json json = toJson(summary);
    json["warnings"] = warnings;
    printJson(json);
  } else if (!arguments.quiet && !arguments.json_progress) {
    printText(options.preview.string() + ": a preview of " + counted(summary.triangles, "triangle") + ", " +
              describeBytes(summary.bytes) + "\n");
  }
}

void runBuild(const BuildArguments& arguments) {
  const ingest::BuildOptions& options = arguments.options;
  checkOutput(options, options.output);
  if (!options.preview.empty()) checkPreview(options);
  std::signal(SIGPIPE, SIG_IGN);  // continue the build even if the reader of its progress exits
  const ingest::BuildReport report = buildUnlessInterrupted(arguments);
  printWarnings(report.warnings);
  if (arguments.json)
    printJson(describeAsJson(report, options.part));
  else if (!arguments.quiet && !arguments.json_progress)
    printText(describe(report, options));
}

/// Sets the inputs that the command line names. @throws Error.
void takeInputs(BuildArguments& arguments) {
  std::vector<std::filesystem::path> inputs = listInputs(arguments.inputs);
  const bool has_stream =
      std::ranges::any_of(inputs, [](const auto& input) { return namesStandardInput(input.string()); });
  if (has_stream && inputs.size() > 1)
    throw Error(ErrorCode::kUsage, "standard input cannot be one of several inputs; save it to a file");
  arguments.options.input = inputs.front();
  arguments.options.more_inputs.assign(inputs.begin() + 1, inputs.end());
}

/// If the input is standard input, copies it into a file and makes the file the input.
/// @return the copy, which must outlive the build; null if the input is a file. @throws Error.
std::unique_ptr<const CopiedInput> takeStandardInput(ingest::BuildOptions& options) {
  if (!namesStandardInput(options.input.string())) return nullptr;
  if (options.resume || options.part != ingest::BuildPart::kWhole)
    throw Error(ErrorCode::kUsage,
                std::string(options.resume ? "--resume" : "--part") +
                    " needs the input a second time; save it to a file, and name the file");
  const std::filesystem::path& output = options.output.empty() ? options.preview : options.output;
  std::filesystem::path folder =
      options.temporary_folder.empty() ? output.parent_path() : options.temporary_folder;
  if (folder.empty()) folder = ".";
  auto copied = std::make_unique<const CopiedInput>(STDIN_FILENO, folder, copyBytesIn(folder));
  options.input = copied->path();
  return copied;
}

/// Exit status of a part that failed for a reason that may pass: a job scheduler should run it again.
/// Source: EX_TEMPFAIL of sysexits.h.
constexpr int kTryAgain = 75;

/// Adds the options of a build in parts. @return --part.
CLI::Option* addParts(CLI::App& command, ingest::BuildOptions& options) {
  const std::map<std::string, ingest::BuildPart> parts{{"prepare", ingest::BuildPart::kPrepare},
                                                       {"simplify", ingest::BuildPart::kSimplify},
                                                       {"finish", ingest::BuildPart::kFinish}};
  CLI::Option* const part =
      command
          .add_option_function<std::string>(
              "--part", [&options, parts](const std::string& name) { options.part = parts.at(name); },
              "build in parts on several machines: prepare, then all tasks of simplify, then finish")
          ->check(CLI::IsMember(parts))
          ->type_name("PART");
  command.add_option("--tasks", options.tasks, "with --part: number of tasks into which simplify is divided")
      ->check(CLI::Range(1u, ingest::kMaxTasks))
      ->needs(part);
  command.add_option("--task", options.task, "with --part simplify: number of the task to run, from 0")
      ->needs(part);
  return part;
}

/// Checks the combination of --part, --tasks and --task. @throws CLI::ValidationError.
void checkParts(const CLI::App& command, const ingest::BuildOptions& options) {
  if (options.part == ingest::BuildPart::kWhole) return;
  if (options.tasks == 0) throw CLI::RequiredError("--tasks");
  const bool is_task = options.part == ingest::BuildPart::kSimplify;
  if (is_task != (command.count("--task") > 0))
    throw CLI::ValidationError("--task", "is for --part simplify, which needs it");
  if (is_task && options.task >= options.tasks)
    throw CLI::ValidationError("--task", "must be less than --tasks");
}

/// Runs a build or a part of one. @return the exit status. @throws Error.
int runOrRetry(const BuildArguments& arguments) {
  try {
    runBuild(arguments);
    return command_line::kDone;
  } catch (const Error& error) {
    const bool may_pass = error.code() == ErrorCode::kIo;
    if (arguments.options.part == ingest::BuildPart::kWhole || !may_pass) throw;
    printOnOneLine("lodestreamd", error.what());
    return kTryAgain;
  }
}

}  // namespace

void addBuildCommand(CLI::App& program, int& exit_status) {
  const auto arguments = std::make_shared<BuildArguments>();
  ingest::BuildOptions& options = arguments->options;
  CLI::App* command = addCommand(program, "build", "Build a store from a PLY file");
  command
      ->add_option(
          "input", arguments->inputs,
          "the PLY file (-: standard input), or several files of one model; a folder: its files *.ply; "
          "@LIST: the files that LIST names, one per line")
      ->required()
      ->type_name("IN.ply");
  CLI::Option* const output =
      command->add_option("-o,--output", options.output, "the store to write")->type_name("OUT.lode");
  command
      ->add_option("--preview", options.preview,
                   "also write a small store of the whole model as soon as the file is read; without -o, "
                   "write only this store")
      ->type_name("OUT.preview.lode");
  addByteSize(
      *command, "--memory", options.memory_bytes,
      "maximum memory, such as 512MB, 1.5GB or 4GiB (default: half of the memory that the process may use)");
  command->add_option("--threads", options.threads, "number of threads (default: one for each core)")
      ->check(CLI::Range(1u, 1024u));
  command
      ->add_option("--tmp", options.temporary_folder,
                   "folder for temporary files (default: the folder of the output)")
      ->type_name("DIR");
  addTexturesFolder(*command, options.textures_folder);
  ingest::forEachResultOption([&](const auto& option) { addResultOption(*command, option, options); });
  CLI::Option* const resume =
      command->add_flag("--resume", options.resume,
                        "continue a killed or interrupted build of the same command; if this build is "
                        "interrupted too, keep its work");
  command
      ->add_flag(
          "--restart-if-changed", options.restart_if_changed,
          "with --resume: start from the beginning if the input, its images or the options have changed")
      ->needs(resume);
  addParts(*command, options)->excludes("--restart-if-changed");
  command
      ->add_option("--lattice-of", options.lattice_of,
                   "build on the lattice of this store, so that unchanged parts of a model keep their bytes")
      ->type_name("OLD.lode")
      ->excludes("--step");
  CLI::Option* const reuse =
      command
          ->add_option("--reuse", options.reuse_folder,
                       "folder of finished parts of models: take equal parts from it, and add new parts")
          ->type_name("DIR");
  addByteSize(*command, "--reuse-size", options.reuse_bytes,
              "with --reuse: remove parts that were unused for longest above this size (default: 16 GB)", 1)
      ->needs(reuse);
  command->add_flag("--json", arguments->json, "print the result as one JSON object");
  CLI::Option* const quiet = command->add_flag("--quiet", arguments->quiet, "print warnings only");
  command
      ->add_flag("--json-progress", arguments->json_progress,
                 "print progress as JSON lines; print the result only with --json")
      ->excludes(quiet);
  command->callback([arguments, command, output, &exit_status] {
    const bool is_part = arguments->options.part != ingest::BuildPart::kWhole;
    if (output->count() == 0 && (is_part || arguments->options.preview.empty()))
      throw CLI::RequiredError(is_part ? "--output" : "--output or --preview");
    checkParts(*command, arguments->options);
    takeInputs(*arguments);
    const std::unique_ptr<const CopiedInput> copied = takeStandardInput(arguments->options);
    if (output->count() == 0) return runPreview(*arguments);
    exit_status = runOrRetry(*arguments);
  });
}

}  // namespace lode::app
