#include <memory>

#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/store/verify.h"

namespace lode::app {
namespace {

struct VerifyArguments {
  std::filesystem::path store;
  store::VerifyOptions options;
  bool json = false;
};

void runVerify(const VerifyArguments& arguments) {
  store::VerifyReport report;
  try {
    report = store::verifyStore(arguments.store, arguments.options);
  } catch (const Error& error) {
    if (arguments.json) printJson({{"sound", false}, {"fault", error.what()}});
    throw;
  }
  if (arguments.json)
    return printJson({{"sound", true},
                      {"bytes", report.bytes},
                      {"blobs", report.blobs},
                      {"nodes", report.nodes},
                      {"payloads", report.payloads},
                      {"stored_triangles", report.triangles},
                      {"open_edges", report.open_edges},
                      {"random_cuts", report.cuts},
                      {"max_rim_gap", report.max_rim_gap_model}});
  printText(arguments.store.string() + ": sound; " + std::to_string(report.blobs) + " blobs, " +
            std::to_string(report.payloads) + " payloads, " + std::to_string(report.triangles) +
            " triangles decoded; " + std::to_string(report.open_edges) + " open edges in the leaves, " +
            std::to_string(report.cuts) + " random cuts agree\n");
}

}  // namespace

void addVerifyCommand(CLI::App& program) {
  const auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* command = addCommand(program, "verify", "Check a store: every byte, payload and invariant");
  command->add_option("store", arguments->store, "the store")->required()->type_name("STORE");
  addMissingOption(*command, "--against",
                   "the PLY file that it was built from: check that nothing is missing");
  command->add_option("--cuts", arguments->options.random_cuts, "random cuts to compare with the leaves")
      ->capture_default_str();
  command->add_option("--seed", arguments->options.seed, "of the first random cut")->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments] { runVerify(*arguments); });
}

}  // namespace lode::app
