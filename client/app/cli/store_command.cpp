#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>

#include <CLI/CLI.hpp>

#include "client/app/cli/built_store.h"
#include "client/app/cli/common_options.h"
#include "common/error.h"

namespace lode::app {
namespace {

struct StoreOptions {
  std::string target;
  std::filesystem::path textures_folder;
};

std::filesystem::path storeOf(const StoreOptions& options) {
  const Target target = parseTarget(options.target, options.textures_folder);
  if (const auto* const store = std::get_if<StoreFile>(&target)) return store->path;
  if (const auto* const ply = std::get_if<PlyFile>(&target)) return builtStore(*ply, true, {}, {}).path;
  throw Error(ErrorCode::kUsage, options.target + " is on a server; name a PLY file or a store");
}

}  // namespace

void declareStore(CLI::App& program, int& /*exit_status*/) {
  CLI::App* command =
      program.add_subcommand("store", "Prints the path of a PLY file's store, which it builds if necessary");
  const auto options = std::make_shared<StoreOptions>();
  command->add_option("target", options->target, "MODEL.ply or STORE.lode")->required()->type_name("TARGET");
  command
      ->add_option("--textures", options->textures_folder, "folder to search first for the images of a PLY")
      ->type_name("DIR");
  command->callback([options] { std::printf("%s\n", storeOf(*options).c_str()); });
}

}  // namespace lode::app
