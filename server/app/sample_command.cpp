#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "common/byte_size.h"
#include "common/io/output_target.h"
#include "common/printable.h"
#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/app/sample_scene.h"
#include "server/sample/sample.h"

namespace lode::app {
namespace {

struct SampleArguments {
  ingest::SampleOptions options;
  std::vector<std::string> attributes;
  std::filesystem::path output;
  bool json = false;
};

AttributeSet parseAttributes(const std::vector<std::string>& names) {
  AttributeSet attributes;
  for (const std::string& name : names) {
    if (name == "normal") attributes.bits |= AttributeSet::kNormal;
    if (name == "color") attributes.bits |= AttributeSet::kColour;
    if (name == "uv") attributes.bits |= AttributeSet::kTexture;
  }
  return attributes;
}

void checkEnding(const std::filesystem::path& output) {
  const std::string ending = output.extension().string();
  if (!ending.empty() && CLI::detail::to_lower(ending) != ".ply" && !findOutput(output).is_stream)
    throw Error(ErrorCode::kUsage, output.string() + ": samples are PLY files, not " + ending +
                                       "; give a name that ends in .ply");
}

void runSample(SampleArguments& arguments) {
  if (arguments.options.kind == "scene") {
    const uint64_t triangles =
        writeSampleScene(arguments.output, arguments.options.triangles, arguments.options.seed);
    if (arguments.json) return printJson({{"triangles", triangles}, {"instances", kSampleSceneInstances}});
    return printText((arguments.output / "scene.json").string() + ": " +
                     std::to_string(kSampleSceneInstances) + " instances of three models of " +
                     std::to_string(triangles) + " triangles together\n");
  }
  checkEnding(arguments.output);
  std::FILE* const report = reportStream(arguments.output, arguments.json);
  arguments.options.attributes = parseAttributes(arguments.attributes);
  const uint64_t triangles = ingest::writeSample(arguments.options, arguments.output);
  std::error_code is_stream;
  const uint64_t bytes = std::filesystem::file_size(arguments.output, is_stream);
  if (arguments.json)
    return printJson({{"triangles", triangles}, {"bytes", is_stream ? Json(nullptr) : Json(bytes)}});
  printText(arguments.output.string() + ": " + counted(triangles, "triangle") +
                (is_stream ? "" : ", " + describeBytes(bytes)) + "\n",
            report);
}

}  // namespace

void addSampleCommand(CLI::App& program) {
  const auto arguments = std::make_shared<SampleArguments>();
  CLI::App* command = addCommand(program, "sample", "Write a procedural test model of any size");
  command
      ->add_option("kind", arguments->options.kind,
                   "kind of model: asteroid, gyroid, terrain, or scene (120 instances of three models)")
      ->required()
      ->check(CLI::IsMember({"asteroid", "gyroid", "terrain", "scene"}))
      ->type_name("KIND");
  command
      ->add_option("--triangles", arguments->options.triangles,
                   "maximum number of triangles, for a scene of each model; the sample has the largest "
                   "possible number")
      ->required()
      ->check(wholeNumber)
      ->type_name("N");
  command->add_option("--attributes", arguments->attributes, "normal, color, uv")
      ->delimiter(',')
      ->check(CLI::IsMember({"normal", "color", "uv"}))
      ->type_name("A,B");
  command->add_option("--seed", arguments->options.seed, "random seed of the model")
      ->check(wholeNumber)
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "the PLY file to write; for a scene, a new folder")
      ->required()
      ->type_name("OUT.ply");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments] { runSample(*arguments); });
}

}  // namespace lode::app
