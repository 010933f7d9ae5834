#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <system_error>
#include <vector>

#include "common/byte_size.h"
#include "common/error.h"
#include "common/io/interrupted.h"
#include "common/io/output_target.h"
#include "common/printable.h"
#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/sample/sample.h"

namespace lode::app {
namespace {

struct SampleArguments {
  ingest::SampleOptions options;
  std::vector<std::string> attributes;
  std::filesystem::path output;
  bool json = false;
};

constexpr size_t kInstances = 120;
constexpr size_t kColumns = 12;
constexpr double kSpacing = 2.6;  // distance between neighbouring models; models are about two units wide

struct SampleModel {
  const char* name;
  const char* kind;
  uint64_t seed;
};
constexpr std::array<SampleModel, 3> kModels{
    {{"rock", "asteroid", 0}, {"boulder", "asteroid", 1}, {"block", "gyroid", 0}}};

/// Returns a uniformly distributed number. Unlike with std::uniform_real_distribution, the number is the same
/// on all machines.
double between(double low, double high, std::mt19937_64& random) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

Json instance(size_t number, std::mt19937_64& random) {
  const double scale = between(0.4, 1.1, random);
  const double x = kSpacing * static_cast<double>(number % kColumns) + between(-0.4, 0.4, random);
  const size_t row = number / kColumns;
  const double y = kSpacing * static_cast<double>(row) + between(-0.4, 0.4, random);
  return {{"model", kModels[number % kModels.size()].name},
          {"position", {x, y, 0.95 * scale}},
          {"axis", {0, 0, 1}},
          {"degrees", between(0, 360, random)},
          {"scale", scale}};
}

Unfinished makeFolder(const std::filesystem::path& folder) {
  const Uninterrupted until_registered;
  std::error_code failed;
  if (std::filesystem::create_directory(folder, failed)) return Unfinished(folder);
  throw Error(ErrorCode::kIo, folder.string() + " cannot be created: " +
                                  (failed ? failed.message() : "it exists") + "; name a new folder");
}

/// Writes the models and scene.json. @return number of triangles written.
uint64_t fillFolder(const std::filesystem::path& folder, uint64_t triangles, uint64_t seed) {
  Json scene;
  scene["up"] = "z";
  uint64_t written = 0;
  for (const SampleModel& model : kModels) {
    ingest::SampleOptions options;
    options.kind = model.kind;
    options.triangles = triangles;
    options.attributes.bits = AttributeSet::kNormal | AttributeSet::kColour;
    options.seed = seed + model.seed;
    const std::string file = std::string(model.name) + ".ply";
    written += ingest::writeSample(options, folder / file);
    scene["models"][model.name] = file;
  }
  std::mt19937_64 random(seed);
  for (size_t number = 0; number < kInstances; ++number)
    scene["instances"].push_back(instance(number, random));
  scene["ground"] = {{"height", 0}, {"colour", "#6a705c"}};
  scene["sky"] = {{"top", "#5f87b4"}, {"bottom", "#c9d6e0"}};
  std::ofstream stream(folder / "scene.json", std::ios::binary);
  stream << scene.dump(1) << "\n" << std::flush;
  if (!stream) throw Error(ErrorCode::kIo, "cannot write " + (folder / "scene.json").string());
  return written;
}

/// Writes three models and a scene.json with kInstances instances of them into a new folder.
/// @param triangles  maximum per model. @return total number of triangles of the three models.
/// @throws Error as ingest::writeSample() does; kIo if the folder exists or cannot be created.
uint64_t writeSampleScene(const std::filesystem::path& folder, uint64_t triangles, uint64_t seed) {
  Unfinished unfinished = makeFolder(folder);
  try {
    const uint64_t written = fillFolder(folder, triangles, seed);
    unfinished.finish();
    return written;
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
    throw;
  }
}

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
    if (arguments.json) return printJson({{"triangles", triangles}, {"instances", kInstances}});
    return printText((arguments.output / "scene.json").string() + ": " + std::to_string(kInstances) +
                     " instances of three models of " + std::to_string(triangles) + " triangles together\n");
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
      ->add_option(
          "--triangles", arguments->options.triangles,
          "maximum number of triangles, in a scene of each model; the sample has the largest possible number")
      ->required()
      ->check(wholeNumber)
      ->type_name("N");
  command->add_option("--attributes", arguments->attributes, "attributes of the vertices: normal, color, uv")
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
