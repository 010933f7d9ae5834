#include "server/app/tiles_options.h"

#include <cmath>
#include <cstdio>
#include <vector>

#include "common/byte_size.h"
#include "common/error.h"
#include "common/printable.h"
#include "common/up_axis.h"
#include "server/app/interruption.h"
#include "server/app/json_output.h"
#include "server/app/progress_bar.h"
#include "server/ingest/plan/machine.h"
#include "server/store/export.h"
#include "server/tiles/tile_export.h"
#include "server/tiles/tile_frame.h"

namespace lode::app {
namespace {

/// Largest height above or below the ellipsoid, in metres; far beyond satellites.
constexpr double kMostHeight = 1e9;

glm::dvec3 upAxis(const TilesArguments& arguments, const store::Reader& reader) {
  if (arguments.up.empty()) {
    const Node& root = reader.nodes().front();
    return guessUp(store::readLod(reader, root, static_cast<uint32_t>(root.lods.size() - 1)));
  }
  const std::optional<glm::dvec3> up = parseAxis(arguments.up);
  if (!up)
    throw Error(ErrorCode::kUsage,
                "'" + arguments.up + "' is not an axis; write --up y or z, or x, -x, -y, -z");
  return *up;
}

std::string nameOf(const glm::dvec3& axis) {
  for (int k = 0; k < 3; ++k)
    if (axis[k] != 0) return std::string(axis[k] < 0 ? "-" : "") + "xyz"[k];
  return "";
}

/// Parses LON,LAT,H. @throws Error kUsage.
tiles::GeoPosition place(const std::string& text) {
  std::vector<double> numbers;
  bool are_numbers = !text.ends_with(',');
  for (const std::string& part : CLI::detail::split(text, ',')) {
    double number = 0;
    are_numbers = are_numbers && CLI::detail::lexical_cast(part, number) && std::isfinite(number);
    numbers.push_back(number);
  }
  if (!are_numbers || numbers.size() != 3 || std::abs(numbers[0]) > 180 || std::abs(numbers[1]) > 90 ||
      std::abs(numbers[2]) > kMostHeight)
    throw Error(ErrorCode::kUsage,
                "'" + text +
                    "' is not a place; write --at LONGITUDE,LATITUDE,HEIGHT in degrees (-180 to 180, "
                    "-90 to 90) and metres, such as --at 7.44,46.95,540");
  return tiles::GeoPosition{numbers[0], numbers[1], numbers[2]};
}

tiles::TileExportReport exportUnlessInterrupted(const TilesArguments& arguments, const store::Reader& reader,
                                                const tiles::TileExportOptions& options) {
  const Interruption interruption("interrupted; nothing was written, start it again", "");
  try {
    ProgressBar bar(stderr, ProgressBar::modeFor(stderr, arguments.quiet));
    const tiles::TileExportReport report =
        tiles::exportTiles(reader, options, [&](uint64_t done, uint64_t total) {
          interruption.check();
          const double fraction = total == 0 ? 1 : static_cast<double>(done) / static_cast<double>(total);
          bar.update("tiles", fraction, done, total);
        });
    bar.finish();
    return report;
  } catch (const Error& error) {
    interruption.endProcessIfReceived(error.what());
    throw;
  }
}

std::string describe(const tiles::TileExportReport& report, const TilesArguments& arguments,
                     const std::string& up) {
  const std::string images = report.images == 0 ? "" : ", " + counted(report.images, "image");
  return arguments.folder.string() + ": " + counted(report.tiles, "tile") + " in " +
         counted(report.glbs, "GLB file") + images + " and " + counted(report.pages, "JSON file") + ", " +
         describeBytes(report.glb_bytes + report.image_bytes + report.json_bytes) + "; " + up + " is up" +
         (arguments.up.empty() ? ", as guessed" : "") + "\n";
}

}  // namespace

void addTilesOptions(CLI::App& command, CLI::Option& tiles, TilesArguments& arguments) {
  command
      .add_option("--up", arguments.up,
                  "up axis of the model for --tiles: y, z, x, -x, -y or -z (default: guessed, y or z)")
      ->needs(&tiles)
      ->type_name("AXIS");
  command
      .add_option("--at", arguments.at,
                  "place of the model's foot on Earth for --tiles: degrees east, degrees north, and metres "
                  "above the ellipsoid")
      ->needs(&tiles)
      ->type_name("LON,LAT,H");
  command
      .add_option("--threads", arguments.threads,
                  "number of threads for --tiles (default: one for each core)")
      ->needs(&tiles)
      ->check(CLI::Range(1u, 1024u));
  command.add_flag("--quiet", arguments.quiet, "print no progress of --tiles")->needs(&tiles);
}

void exportAsTiles(const TilesArguments& arguments) {
  const store::Reader reader(arguments.store);
  const glm::dvec3 up = upAxis(arguments, reader);
  const tiles::TileExportOptions options{
      .folder = arguments.folder,
      .root_transform = tiles::rootTransform(
          reader.summary(), up, arguments.at ? std::optional(place(*arguments.at)) : std::nullopt),
      .threads = arguments.threads > 0 ? arguments.threads : ingest::defaultThreads()};
  const tiles::TileExportReport report = exportUnlessInterrupted(arguments, reader, options);
  if (!arguments.json) return printText(describe(report, arguments, nameOf(up)));
  printJson({{"tiles", report.tiles},
             {"glb_files", report.glbs},
             {"image_files", report.images},
             {"json_files", report.pages},
             {"glb_bytes", report.glb_bytes},
             {"image_bytes", report.image_bytes},
             {"json_bytes", report.json_bytes},
             {"up", nameOf(up)}});
}

}  // namespace lode::app
