#include <memory>
#include <optional>
#include <vector>

#include "common/io/mesh_file.h"
#include "common/io/output_target.h"
#include "common/printable.h"
#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/app/tiles_options.h"
#include "server/store/export.h"

namespace lode::app {
namespace {

struct ExportArguments {
  std::filesystem::path store, output;
  std::optional<double> error;
  std::optional<uint64_t> triangles, seed;
  TilesArguments tiles;
  bool json = false;
};

/// Checks that a number is not negative. CLI11's NonNegativeNumber would print all digits of the largest
/// double in its message.
std::string atLeastZero(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value >= 0 ? ""
                                                              : "must be a number of 0 or more, not " + text;
}

store::Cut chooseCut(const ExportArguments& arguments, const store::Reader& reader) {
  const store::NodeTree tree(reader.nodes());
  if (arguments.error) {
    store::Cut cut = store::cutByError(tree, *arguments.error * boxDiagonal(reader.summary()));
    cut.converged = cut.converged || *arguments.error == 0;  // --error 0 means the finest cut
    return cut;
  }
  if (arguments.triangles) return store::cutByTriangles(tree, *arguments.triangles);
  return store::randomCut(tree, *arguments.seed);
}

Json describeAsJson(const store::Cut& cut, const store::Reader& reader) {
  uint64_t bytes = 0;
  for (const store::CutItem item : cut.items) bytes += reader.nodes()[item.node].lods[item.lod].payload.bytes;
  return {{"triangles", cut.triangles},
          {"nodes", cut.items.size()},
          {"bytes", bytes},
          {"max_error", cut.max_error_model},
          {"max_error_of_diagonal", cut.max_error_model / boxDiagonal(reader.summary())},
          {"converged", cut.converged},
          {"finest", cut.triangles == reader.summary().triangles}};
}

std::string describe(const Json& json, const std::filesystem::path& output) {
  return output.string() + ": " + counted(json["triangles"], "triangle") + " of " +
         counted(json["nodes"], "node") + ", largest error " + json["max_error"].dump() +
         (json["finest"] ? ", that of the lattice; the store has nothing finer" : "") + "\n";
}

/// Returns the error message for a cut that exceeds the bound.
std::string describeFailure(const ExportArguments& arguments, const store::Cut& cut) {
  if (arguments.triangles)
    return "its coarsest cut has " + std::to_string(cut.triangles) + " triangles; ask for at least as many";
  return "even the finest cut, which was written, has a larger error because of the lattice; ask for a "
         "larger error, or for the finest cut with --error 0";
}

void runExport(const ExportArguments& arguments) {
  meshFormatOf(arguments.output);  // report an unknown format before the work
  const store::Reader reader(arguments.store);
  std::error_code ignored;
  if (std::filesystem::equivalent(arguments.store, arguments.output, ignored))
    throw Error(ErrorCode::kUsage, arguments.output.string() + " is the store itself; name another output");
  if (!reader.textures().textures.empty()) refuseFilesBesideStream(arguments.output);
  std::FILE* const report = reportStream(arguments.output, arguments.json);
  const store::Cut cut = chooseCut(arguments, reader);
  Json json = describeAsJson(cut, reader);
  const bool is_too_large = arguments.triangles && !cut.converged;
  std::vector<std::filesystem::path> beside;
  if (!is_too_large) beside = store::exportCut(reader, cut, arguments.output);
  json["files_beside"] = Json::array();
  for (const std::filesystem::path& file : beside) json["files_beside"].push_back(file.string());
  if (arguments.json) printJson(json);
  if (!cut.converged)
    throw Error(ErrorCode::kInput, arguments.store.string() + ": " + describeFailure(arguments, cut));
  if (!arguments.json) printText(describe(json, arguments.output) + describeFilesBeside(beside), report);
}

}  // namespace

void addExportCommand(CLI::App& program) {
  const auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = addCommand(
      program, "export",
      "Write a cut of a store with its attributes as PLY, OBJ or GLB, and its textures in files beside it; "
      "or write the whole store as 3D Tiles");
  command->add_option("store", arguments->store, "the store")->required()->type_name("STORE");
  CLI::Option_group* which = command->add_option_group("cut", "cut to write, or --tiles");
  which
      ->add_option(
          "--error", arguments->error,
          "the coarsest cut with at most this error, as a fraction of the box diagonal; 0: the finest cut")
      ->check(atLeastZero)
      ->type_name("E");
  which->add_option("--triangles", arguments->triangles, "the best cut of at most this many triangles")
      ->check(wholeNumber)
      ->type_name("N");
  which->add_option("--random", arguments->seed, "a random cut")->check(wholeNumber)->type_name("SEED");
  CLI::Option* const tiles =
      which
          ->add_option("--tiles", arguments->tiles.folder,
                       "all LODs as 3D Tiles 1.1, for CesiumJS, three.js and other viewers, in a new folder")
          ->type_name("DIR");
  which->require_option(1);
  CLI::Option* const output =
      command
          ->add_option("-o,--output", arguments->output,
                       "the file to write for a cut; its extension selects the format")
          ->excludes(tiles)
          ->type_name("CUT.ply|.obj|.glb");
  addTilesOptions(*command, *tiles, arguments->tiles);
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, tiles, output] {
    if (tiles->count() == 0) {
      if (output->count() == 0) throw CLI::RequiredError("--output");
      return runExport(*arguments);
    }
    arguments->tiles.store = arguments->store;
    arguments->tiles.json = arguments->json;
    exportAsTiles(arguments->tiles);
  });
}

}  // namespace lode::app
