#include <charconv>
#include <memory>
#include <optional>

#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/app/progress_bar.h"
#include "server/ingest/inspect/against.h"
#include "server/ingest/inspect/error_witness.h"
#include "server/store/node_tree.h"
#include "server/store/verify.h"

namespace lode::app {
namespace {

struct VerifyArguments {
  std::filesystem::path store;
  store::VerifyOptions options;
  /// Comparison with the input; without an input, the command checks only the store.
  ingest::AgainstOptions against;
  bool json = false, quiet = false;
};

Json reportAsJson(const store::VerifyReport& report) {
  return {{"sound", true},
          {"bytes", report.bytes},
          {"blobs", report.blobs},
          {"nodes", report.nodes},
          {"payloads", report.payloads},
          {"stored_triangles", report.triangles},
          {"tiles", report.tiles},
          {"open_edges", report.open_edges},
          {"random_cuts", report.cuts},
          {"max_boundary_gap", report.max_boundary_gap_model}};
}

Json againstAsJson(const ingest::AgainstReport& report) {
  const auto ofMeasured = [&](double ratio) { return report.lods > 0 ? Json(ratio) : Json(nullptr); };
  return {{"triangles", report.triangles},
          {"dropped", report.dropped},
          {"lods_sampled", report.lods},
          {"lods_below", report.lods_below},
          {"least_ratio", ofMeasured(report.least_ratio)},
          {"median_ratio", ofMeasured(report.median_ratio)}};
}

Json witnessAsJson(const ingest::ErrorWitness& witness) {
  const auto asJson = [](glm::dvec3 point) { return Json{point.x, point.y, point.z}; };
  return {{"node", store::describeKey(witness.node)},
          {"lod", witness.lod},
          {"stored_error", witness.stored_error},
          {"distance", witness.distance},
          {"point", asJson(witness.point)},
          {"point_of", witness.of_lod ? "lod" : "input"},
          {"nearest", asJson(witness.nearest)},
          {"between", witness.on_boundary ? "boundaries" : "surfaces"}};
}

std::string describe(const store::VerifyReport& report) {
  return "sound; " + std::to_string(report.blobs) + " blobs, " + std::to_string(report.payloads) +
         " payloads, " + std::to_string(report.triangles) + " triangles decoded" +
         (report.tiles > 0 ? ", " + std::to_string(report.tiles) + " tiles of textures" : "") + "; " +
         std::to_string(report.open_edges) + " open edges in the leaves, " + std::to_string(report.cuts) +
         " random cuts agree";
}

std::string describe(const ingest::AgainstReport& report) {
  char ratios[80];
  std::snprintf(ratios, sizeof ratios, "at least %.2f times the measured ones, %.2f at the median",
                report.least_ratio, report.median_ratio);
  std::string text = "; all " + std::to_string(report.triangles) + " triangles of the input are present, " +
                     std::to_string(report.dropped) + " dropped";
  if (report.lods > 0) text += "; stored errors of " + std::to_string(report.lods) + " LODs are " + ratios;
  return text;
}

ingest::AgainstReport compare(const VerifyArguments& arguments,
                              std::optional<ingest::ErrorWitness>& witness) {
  ingest::AgainstOptions against = arguments.against;
  against.store = arguments.store;
  against.seed = arguments.options.seed;
  ProgressBar bar(stderr, ProgressBar::modeFor(stderr, arguments.quiet));
  const ingest::AgainstReport compared = ingest::compareWithInput(
      against,
      [&](std::string_view stage, double fraction, uint64_t done, uint64_t total) {
        bar.update(stage, fraction, done, total);
      },
      &witness);
  bar.finish();
  return compared;
}

void runVerify(const VerifyArguments& arguments) {
  std::optional<store::VerifyReport> report;
  std::optional<ingest::AgainstReport> compared;
  std::optional<ingest::ErrorWitness> witness;
  try {
    report = store::verifyStore(arguments.store, arguments.options);
    if (!arguments.against.input.empty()) compared = compare(arguments, witness);
  } catch (const Error& error) {
    // Do not blame the store if it could not be read, or if the error is in the input.
    const bool is_fault = error.code() == ErrorCode::kFormat || (!report && error.code() != ErrorCode::kIo);
    if (arguments.json && is_fault) {
      Json json{{"sound", false}, {"fault", error.what()}};
      if (witness) json["witness"] = witnessAsJson(*witness);
      printJson(json);
    }
    throw;
  }
  if (!arguments.json)
    return printText(arguments.store.string() + ": " + describe(*report) +
                     (compared ? describe(*compared) : "") + "\n");
  Json json = reportAsJson(*report);
  if (compared) json["against"] = againstAsJson(*compared);
  printJson(json);
}

/// Parses the number of LODs. @return 0 for "all".
size_t countOfLods(const std::string& text) {
  size_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  const bool is_count = error == std::errc() && end == text.data() + text.size() && count > 0;
  if (!is_count && text != "all")
    throw CLI::ValidationError("--lods", "must be a number above 0 or all, not " + text);
  return is_count ? count : 0;
}

}  // namespace

void addVerifyCommand(CLI::App& program) {
  const auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* command = addCommand(program, "verify", "Check a store: every byte, payload and invariant");
  command->add_option("store", arguments->store, "the store")->required()->type_name("STORE");
  ingest::AgainstOptions& against = arguments->against;
  CLI::Option* const input = command
                                 ->add_option("--against", against.input,
                                              "PLY file from which the store was built: check that no "
                                              "triangle is missing, and measure errors")
                                 ->type_name("IN.ply");
  command
      ->add_option_function<std::string>(
          "--lods", [arguments](const std::string& text) { arguments->against.lods = countOfLods(text); },
          "maximum number of LODs to measure with --against, spread over the tree (default: all)")
      ->needs(input)
      ->type_name("N|all");
  command
      ->add_option("--threads", against.threads,
                   "number of threads that read and measure (default: one for each core)")
      ->check(CLI::Range(1u, 1024u));
  addByteSize(
      *command, "--memory", against.memory_bytes,
      "maximum memory with --against, such as 512MB (default: half of the memory that the process may use)");
  command
      ->add_option("--tmp", against.temporary_folder,
                   "folder for temporary files of --against (default: the system's)")
      ->type_name("DIR");
  command
      ->add_option("--cuts", arguments->options.random_cuts,
                   "number of random cuts to compare with the leaves")
      ->check(wholeNumber)
      ->capture_default_str();
  command
      ->add_option("--seed", arguments->options.seed,
                   "seed of the random cuts and of the choice of LODs and points")
      ->check(wholeNumber)
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->add_flag("--quiet", arguments->quiet, "print no progress");
  command->callback([arguments] { runVerify(*arguments); });
}

}  // namespace lode::app
