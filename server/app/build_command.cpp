#include <csignal>
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
  bool json = false, quiet = false, json_progress = false;
};

Json describeAsJson(const ingest::BuildReport& report) {
  Json json = toJson(report.summary);
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

std::string describe(const ingest::BuildReport& report, const std::filesystem::path& output) {
  const ModelSummary& summary = report.summary;
  char numbers[160];
  std::snprintf(
      numbers, sizeof numbers, "%.1f s, %.1f CPU s, %.2f M triangles a CPU second, peak memory ",
      report.seconds, report.cpu_seconds,
      report.cpu_seconds > 0 ? static_cast<double>(summary.triangles) / report.cpu_seconds / 1e6 : 0.0);
  return output.string() + ": " + counted(summary.triangles, "triangle") + " in " +
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
  refuseIf(options.input, "the input itself");
  TextureFinder finder(options.input, options.textures_folder);
  for (const std::string& name : ingest::readPlyHeader(options.input).texture_files)
    refuseIf(finder.find(name).path, "a texture image of the input");
}

/// Checks the path of a preview that a build writes beside its output. @throws Error kUsage.
void checkPreview(const ingest::BuildOptions& options) {
  checkOutput(options, options.preview);
  if (std::filesystem::weakly_canonical(options.preview) == std::filesystem::weakly_canonical(options.output))
    throw Error(ErrorCode::kUsage, options.preview.string() + ": is the output itself; name another preview");
}

ingest::BuildReport buildUnlessInterrupted(const BuildArguments& arguments) {
  const bool is_kept = arguments.options.resume;
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
    printJson(describeAsJson(report));
  else if (!arguments.quiet && !arguments.json_progress)
    printText(describe(report, options.output));
}

/// If the input is standard input, copies it into a file and makes the file the input.
/// @return the copy, which must outlive the build; null if the input is a file. @throws Error.
std::unique_ptr<const CopiedInput> takeStandardInput(ingest::BuildOptions& options) {
  if (!namesStandardInput(options.input.string())) return nullptr;
  if (options.resume)
    throw Error(ErrorCode::kUsage,
                "--resume needs the input a second time; save it to a file, and name the file");
  const std::filesystem::path& output = options.output.empty() ? options.preview : options.output;
  std::filesystem::path folder =
      options.temporary_folder.empty() ? output.parent_path() : options.temporary_folder;
  if (folder.empty()) folder = ".";
  auto copied = std::make_unique<const CopiedInput>(STDIN_FILENO, folder, copyBytesIn(folder));
  options.input = copied->path();
  return copied;
}

}  // namespace

void addBuildCommand(CLI::App& program) {
  const auto arguments = std::make_shared<BuildArguments>();
  ingest::BuildOptions& options = arguments->options;
  CLI::App* command = addCommand(program, "build", "Build a store from a PLY file");
  command->add_option("input", options.input, "the PLY file; -: standard input")
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
  command->add_flag("--json", arguments->json, "print the result as one JSON object");
  CLI::Option* const quiet = command->add_flag("--quiet", arguments->quiet, "print warnings only");
  command
      ->add_flag("--json-progress", arguments->json_progress,
                 "print progress as JSON lines; print the result only with --json")
      ->excludes(quiet);
  command->callback([arguments, output] {
    if (output->count() == 0 && arguments->options.preview.empty())
      throw CLI::RequiredError("--output or --preview");
    const std::unique_ptr<const CopiedInput> copied = takeStandardInput(arguments->options);
    output->count() > 0 ? runBuild(*arguments) : runPreview(*arguments);
  });
}

}  // namespace lode::app
