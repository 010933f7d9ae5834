#include "server/app/sample_scene.h"

#include <array>
#include <fstream>
#include <random>

#include "common/error.h"
#include "common/io/interrupted.h"
#include "server/app/json_output.h"
#include "server/sample/sample.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kColumns = 12;
constexpr double kSpacing = 2.6;  // in model units; models are about two wide

struct SampleModel {
  const char* name;
  const char* kind;
  uint64_t seed;
};
constexpr std::array<SampleModel, 3> kModels{
    {{"rock", "asteroid", 0}, {"boulder", "asteroid", 1}, {"block", "gyroid", 0}}};

/// Returns a uniform number that is equal on all machines, unlike std::uniform_real_distribution.
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

Unfinished makeFolder(const fs::path& folder) {
  const Uninterrupted until_registered;
  std::error_code failed;
  if (fs::create_directory(folder, failed)) return Unfinished(folder);
  throw Error(ErrorCode::kIo, folder.string() + " cannot be created: " +
                                  (failed ? failed.message() : "it exists") + "; name a new folder");
}

/// Writes the models and scene.json. @return number of triangles written.
uint64_t fillFolder(const fs::path& folder, uint64_t triangles, uint64_t seed) {
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
  for (size_t number = 0; number < kSampleSceneInstances; ++number)
    scene["instances"].push_back(instance(number, random));
  scene["ground"] = {{"height", 0}, {"colour", "#6a705c"}};
  scene["sky"] = {{"top", "#5f87b4"}, {"bottom", "#c9d6e0"}};
  std::ofstream stream(folder / "scene.json", std::ios::binary);
  stream << scene.dump(1) << "\n" << std::flush;
  if (!stream) throw Error(ErrorCode::kIo, "cannot write " + (folder / "scene.json").string());
  return written;
}

}  // namespace

uint64_t writeSampleScene(const fs::path& folder, uint64_t triangles, uint64_t seed) {
  Unfinished unfinished = makeFolder(folder);
  try {
    const uint64_t written = fillFolder(folder, triangles, seed);
    unfinished.finish();
    return written;
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    throw;
  }
}

}  // namespace lode::app
