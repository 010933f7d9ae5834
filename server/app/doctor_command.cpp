#include <array>
#include <charconv>
#include <memory>
#include <span>
#include <vector>

#include "common/byte_size.h"
#include "common/command_line.h"
#include "common/printable.h"
#include "server/app/command.h"
#include "server/app/input_list.h"
#include "server/app/json_output.h"
#include "server/ingest/inspect/doctor.h"

namespace lode::app {
namespace {

struct DoctorArguments {
  ingest::DoctorOptions options;
  std::vector<std::string> inputs;  ///< words that name the input; see listInputs()
  bool json = false;
};

const char* encodingName(ingest::PlyEncoding encoding) {
  switch (encoding) {
    case ingest::PlyEncoding::kAscii:
      return "ascii";
    case ingest::PlyEncoding::kLittleEndian:
      return "binary_little_endian";
    case ingest::PlyEncoding::kBigEndian:
      break;
  }
  return "binary_big_endian";
}

Json pointAsJson(glm::dvec3 v) { return {v.x, v.y, v.z}; }

/// Formats a value with the fewest digits that parse to the same value: as a float if a float can represent
/// the value, else as a double.
std::string describe(double value) {
  const auto as_float = static_cast<float>(value);
  std::array<char, 32> text{};
  const auto end = static_cast<double>(as_float) == value ? std::to_chars(text.begin(), text.end(), as_float)
                                                          : std::to_chars(text.begin(), text.end(), value);
  return {text.begin(), end.ptr};
}

std::string describe(glm::dvec3 v) {
  return "[" + describe(v.x) + ", " + describe(v.y) + ", " + describe(v.z) + "]";
}

Json topologyAsJson(const ingest::Topology& topology) {
  return {{"duplicate_vertices", topology.duplicate_vertices},
          {"unused_vertices", topology.unused_vertices},
          {"flat_faces", topology.flat_faces},
          {"open_edges", topology.open_edges},
          {"non_manifold_edges", topology.non_manifold_edges},
          {"misoriented_edges", topology.misoriented_edges},
          {"pieces", topology.pieces},
          {"opposed_faces", topology.opposed_faces},
          {"lost_triangles", topology.lost_triangles},
          {"lattice_step", topology.lattice_step}};
}

Json forecastAsJson(const ingest::BuildForecast& forecast) {
  return {{"seconds", forecast.seconds},
          {"cpu_seconds", forecast.cpu_seconds},
          {"memory_bytes", forecast.memory_bytes},
          {"temporary_bytes", forecast.temporary_bytes},
          {"store_bytes", forecast.store_bytes}};
}

Json describeAsJson(const ingest::DoctorReport& report) {
  Json json{{"buildable", report.is_buildable},
            {"buildable_with_skip_bad", report.is_readable},
            {"file_bytes", report.file_bytes}};
  if (report.header) {
    json["encoding"] = encodingName(report.header->encoding);
    json["elements"] = Json::array();
    for (const ingest::PlyElement& element : report.header->elements)
      json["elements"].push_back({{"name", element.name}, {"count", element.count}});
  }
  json["vertices"] = report.counts.vertices;
  json["faces"] = report.counts.faces;
  json["triangles"] = report.counts.triangles;
  json["dropped_faces"] = report.counts.dropped_faces;
  json["skipped_bad"] = report.counts.skipped_bad;
  json["replaced_attributes"] = report.counts.replaced_attributes;
  json["attributes"] = attributeNames(report.attributes);
  json["skipped_properties"] = report.skipped_properties;
  json["textures"] = Json::array();
  for (const auto& texture : report.textures)
    json["textures"].push_back({{"name", texture.name},
                                {"found", !texture.path.empty()},
                                {"path", texture.path.empty() ? Json() : Json(texture.path.string())}});
  if (report.is_readable) json["box"] = {{"min", pointAsJson(report.min)}, {"max", pointAsJson(report.max)}};
  json["topology"] = report.topology ? topologyAsJson(*report.topology) : Json();
  json["problems"] = Json::array();
  for (const auto& problem : report.problems)
    json["problems"].push_back({{"fatal", problem.is_fatal}, {"text", problem.text}});
  json["forecast"] = report.forecast ? forecastAsJson(*report.forecast) : Json();
  return json;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? "none" : text;
}

class Sheet {
 public:
  void line(const char* name, const std::string& value) {
    std::string start(name);
    start.resize(18, ' ');
    text_ += start + value + "\n";
  }
  const std::string& text() const noexcept { return text_; }

 private:
  std::string text_;
};

/// Returns the number of rows read: "90". If the file ends too early, adds the declared number: "90 of 100".
std::string rowsInWords(const ingest::DoctorReport& report, uint64_t read, const char* element) {
  const ingest::PlyElement* declared = report.header ? report.header->find(element) : nullptr;
  const bool is_part = !report.is_readable && declared != nullptr && read < declared->count;
  return std::to_string(read) + (is_part ? " of " + std::to_string(declared->count) : "");
}

/// Returns the suffix printed after a texture's name: " (missing)", the image's path if the image has another
/// name than in the PLY file, or nothing.
std::string placeInWords(const std::filesystem::path& path, const std::string& name) {
  if (path.empty()) return " (missing)";
  return path.filename() == name ? "" : " (is " + path.string() + ")";
}

std::string describe(const ingest::DoctorReport& report) {
  Sheet sheet;
  const ingest::PlyCounts& counts = report.counts;
  if (report.header)
    sheet.line("encoding",
               std::string(encodingName(report.header->encoding)) + ", " + describeBytes(report.file_bytes));
  sheet.line("vertices", rowsInWords(report, counts.vertices, "vertex"));
  sheet.line("faces",
             rowsInWords(report, counts.faces, "face") + ", " + counted(counts.triangles, "triangle"));
  sheet.line("attributes", joined(attributeNames(report.attributes)));
  for (const auto& texture : report.textures)
    sheet.line("texture", texture.name + placeInWords(texture.path, texture.name));
  if (report.is_readable) sheet.line("box", describe(report.min) + " to " + describe(report.max));
  if (report.topology) {
    const ingest::Topology& topology = *report.topology;
    sheet.line("pieces", std::to_string(topology.pieces));
    sheet.line("duplicates", counted(topology.duplicate_vertices, "vertex", "vertices"));
    sheet.line("open edges", std::to_string(topology.open_edges));
    sheet.line("non-manifold", counted(topology.non_manifold_edges, "edge"));
  } else if (report.is_readable) {
    sheet.line("topology", "not analysed: too many vertices to index");
  }
  if (report.forecast) {
    const ingest::BuildForecast& forecast = *report.forecast;
    char seconds[80];
    std::snprintf(seconds, sizeof seconds, "about %.1f s (%.1f CPU s), ", forecast.seconds,
                  forecast.cpu_seconds);
    sheet.line("a build takes", seconds + describeBytes(forecast.memory_bytes) + " of memory, " +
                                    describeBytes(forecast.temporary_bytes) + " of temporary disk; store " +
                                    describeBytes(forecast.store_bytes));
  }
  for (const auto& problem : report.problems)
    sheet.line(problem.is_fatal ? "ERROR" : "warning", problem.text);
  sheet.line("verdict", report.is_buildable  ? "can be built"
                        : report.is_readable ? "can be built with --skip-bad only"
                                             : "cannot be built");
  return sheet.text();
}

/// Returns "A.ply, B.ply: 61 places of their borders meet".
std::string describe(const ingest::BorderGap& gap, std::span<const std::filesystem::path> inputs) {
  const std::string names = inputs[gap.first].string() + ", " + inputs[gap.second].string() + ": ";
  const std::string places = counted(gap.places, "place") + " of their borders";
  if (gap.apart == 0) return names + places + " meet";
  return names + std::to_string(gap.apart) + " of " + places + " lie apart, by up to " +
         describe(gap.farthest_model);
}

/// Examines several files of one model, and compares their borders.
void examineAll(const DoctorArguments& arguments, std::span<const std::filesystem::path> inputs) {
  std::vector<ingest::OpenBorder> borders;
  Json json{{"files", Json::array()}, {"borders", Json::array()}};
  std::string fatal;
  for (const std::filesystem::path& input : inputs) {
    ingest::DoctorOptions options = arguments.options;
    options.input = input;
    ingest::DoctorReport report = ingest::examine(options);
    if (arguments.json)
      json["files"].push_back(describeAsJson(report));
    else
      printText(input.string() + "\n" + describe(report) + "\n");
    for (const auto& problem : report.problems)
      if (problem.is_fatal && fatal.empty()) fatal = problem.text;
    borders.push_back(report.topology ? std::move(report.topology->border) : ingest::OpenBorder());
  }
  for (const ingest::BorderGap& gap : ingest::compareBorders(borders)) {
    if (!arguments.json) printText(describe(gap, inputs) + "\n");
    json["borders"].push_back({{"files", {inputs[gap.first].string(), inputs[gap.second].string()}},
                               {"places", gap.places},
                               {"apart", gap.apart},
                               {"farthest", gap.farthest_model}});
  }
  if (arguments.json) printJson(json);
  if (!fatal.empty()) throw Error(ErrorCode::kInput, fatal);
}

void runDoctor(DoctorArguments& arguments) {
  const std::vector<std::filesystem::path> inputs = listInputs(arguments.inputs);
  if (inputs.size() > 1) return examineAll(arguments, inputs);
  arguments.options.input = inputs.front();
  const ingest::DoctorReport report = ingest::examine(arguments.options);
  if (arguments.json)
    printJson(describeAsJson(report));
  else
    printText(describe(report));
  if (report.is_buildable) return;
  for (const auto& problem : report.problems)
    if (problem.is_fatal) throw Error(ErrorCode::kInput, problem.text);
}

}  // namespace

void addDoctorCommand(CLI::App& program) {
  const auto arguments = std::make_shared<DoctorArguments>();
  ingest::DoctorOptions& options = arguments->options;
  CLI::App* command =
      addCommand(program, "doctor", "Describe a PLY file, its problems and the cost of a build");
  command
      ->add_option("input", arguments->inputs,
                   "the PLY file; or several files, a folder or @LIST, to compare their borders too")
      ->required()
      ->type_name("IN.ply");
  addByteSize(*command, "--memory", options.memory_bytes,
              "approximate memory for counting edges and pieces, and memory limit of the forecast build, "
              "such as 512MB (default: half of the memory that the process may use)");
  command
      ->add_option("--threads", options.threads,
                   "number of threads of the forecast build (default: one for each core)")
      ->check(CLI::Range(1u, 1024u));
  command
      ->add_option("--tmp", options.temporary_folder,
                   "folder for temporary files, about 45 bytes per triangle (default: the system's)")
      ->type_name("DIR");
  addTexturesFolder(*command, options.textures_folder);
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments] { runDoctor(*arguments); });
}

}  // namespace lode::app
