#include "server/ingest/build/build.h"

#include <exception>
#include <string>
#include <string_view>

#include "common/error.h"
#include "server/ingest/build/build_steps.h"
#include "server/ingest/plan/machine.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kMinTrianglesPerNode = 64;

BuildOptions withDefaults(BuildOptions options) {
  if (options.memory_bytes == 0) options.memory_bytes = defaultMemoryBytes();
  if (options.threads == 0) options.threads = defaultThreads();
  if (options.temporary_folder.empty()) {
    options.temporary_folder = options.output.has_parent_path() ? options.output.parent_path() : ".";
  }
  if (options.triangles_per_node < kMinTrianglesPerNode) {
    throw Error(ErrorCode::kUsage,
                "--triangles-per-node must be at least " + std::to_string(kMinTrianglesPerNode));
  }
  return options;
}

/// How a build that failed may go on; empty where it would only fail again.
std::string_view wayOn(const Error& error, const BuildSteps& steps) noexcept {
  if (error.code() == ErrorCode::kIo) return "the same command goes on from there";
  return steps.lacksMemory() ? "with more memory the same command goes on from there" : "";
}

}  // namespace

BuildReport build(const BuildOptions& given, const BuildProgress& progress) {
  BuildSteps steps(withDefaults(given), progress);
  try {
    steps.scan();
    steps.textures();
    steps.dereference();
    steps.partition();
    steps.simplify();
    steps.pack();
    return steps.report();
  } catch (const Error& error) {
    const std::string_view way_on = wayOn(error, steps);
    if (!given.resume || way_on.empty() || !steps.keep()) throw;
    throw Error(error.code(),
                std::string(error.what()) + "; what is finished is kept, " + std::string(way_on));
  } catch (const std::exception&) {
    if (given.resume) steps.keep();
    throw;
  }
}

}  // namespace lode::ingest
