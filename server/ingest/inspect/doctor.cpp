#include "server/ingest/inspect/doctor.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "common/error.h"
#include "common/io/texture_finder.h"
#include "common/printable.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/ingest/ply/ply_input.h"
#include "server/ingest/soup/lost_triangles.h"
#include "server/ingest/soup/scan.h"
#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {
namespace {

/// Largest number of defects of each kind that the report lists one by one.
constexpr uint64_t kShownDefects = 5;

class Doctor {
 public:
  explicit Doctor(const DoctorOptions& given) : options_(given), name_(given.input.string()) {}

  DoctorReport run() {
    report_.file_bytes = PlyInput(options_.input).size();
    if (!tryTo([&] { report_.header = readPlyHeader(options_.input); })) return report_;
    report_.is_readable = tryTo([&] { readBody(); });
    if (reader_) report_.counts = reader_->counts();
    checkTextures();
    reportDefects();
    if (report_.is_readable && report_.counts.vertices <= UINT32_MAX) report_.topology = topology_->count();
    topology_.reset();
    folder_.reset();
    if (report_.is_readable) checkModel();
    if (report_.is_readable) checkMemory();
    report_.is_buildable =
        report_.is_readable && std::none_of(report_.problems.begin(), report_.problems.end(),
                                            [](const auto& problem) { return problem.is_fatal; });
    if (report_.is_readable) forecast();
    return report_;
  }

 private:
  struct Defects {
    uint64_t count = 0;
    std::vector<std::string> first;
  };

  uint64_t budget() const { return options_.memory_bytes ? options_.memory_bytes : defaultMemoryBytes(); }

  std::filesystem::path temporaryFolder() const {
    return options_.temporary_folder.empty() ? std::filesystem::temp_directory_path()
                                             : options_.temporary_folder;
  }

  void addProblem(bool is_fatal, const std::string& text) { report_.problems.push_back({is_fatal, text}); }

  /// Calls `work`, and turns an error into a fatal problem, except kIo, which it rethrows. @return true if
  /// `work` succeeded.
  template <typename Work>
  bool tryTo(Work&& work) {
    try {
      work();
      return true;
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kIo) throw;
      addProblem(true, error.what());
      return false;
    }
  }

  void checkTextures() {
    const std::vector<std::string>& names = report_.header->texture_files;
    // A build ignores the images of a model without texture coordinates.
    const uint64_t image_bytes = planMemory(budget(), 1, 1).image_bytes;
    if (report_.attributes.has(AttributeSet::kTexture))
      tryTo([&] {
        images_ = surveyTextures(imagesOf(options_.input, names), options_.textures_folder, image_bytes);
      });
    for (TextureImage& image : images_)
      if (image.problem.empty()) decodeImage(image, image_bytes);
    TextureFinder finder(options_.input, options_.textures_folder);
    for (size_t i = 0; i < names.size(); ++i) {
      if (i >= images_.size()) {
        const TextureFile file = finder.find(names[i]);
        noteTexture(names[i], file.path, file.problem, false);
      } else {
        noteTexture(names[i], images_[i].path, images_[i].problem, images_[i].needs_memory);
      }
    }
  }

  /// Decodes the whole image, because an intact header may be followed by damaged pixels.
  void decodeImage(TextureImage& image, uint64_t memory_bytes) {
    std::string damage;
    try {
      readImage(image.path, memory_bytes, damage);
    } catch (const Error& error) {
      image.problem = error.what();
      image.needs_memory = error.code() == ErrorCode::kLimit;
      image.header = {};
    }
    if (!damage.empty()) addProblem(false, textureInWords(options_.input, image.name) + " " + damage);
  }

  void noteTexture(const std::string& name, const std::filesystem::path& path, const std::string& problem,
                   bool needs_memory) {
    report_.textures.push_back({name, path});
    if (problem.empty()) return;
    const std::string words = textureInWords(options_.input, name) + " " + problem;
    addProblem(needs_memory, needs_memory ? words : words + "; a build continues without it");
  }

  void readBody() {
    const auto start = cpuSeconds();
    PlyReadOptions read_options{.skip_bad = true, .read_truncated = true};
    read_options.on_defect = [&](const PlyDefect& defect) {
      Defects& defects = defect.is_bad ? bad_ : dropped_;
      if (defects.count < kShownDefects) defects.first.push_back(defect.text);
      defects.count += defect.rows;
    };
    PlyReader& reader = reader_.emplace(options_.input, read_options);
    report_.attributes = reader.attributes();
    folder_.emplace(temporaryFolder());
    topology_.emplace(*folder_, reader.attributes(), hasDoublePositions(reader.header()), budget());
    double beside = 0;  // CPU time of all work except reading, in seconds
    const auto addToTopology = [&](auto&& add) {
      const double before = cpuSeconds();
      add(*topology_);
      beside += cpuSeconds() - before;
    };
    face_attributes_ = reader.faceAttributes();
    ignores_face_colours_ = reader.ignoresFaceColours();
    report_.skipped_properties = reader.skippedProperties();
    report_.min = glm::dvec3(std::numeric_limits<double>::max());
    report_.max = -report_.min;
    reader.read(
        [&](uint64_t, std::span<const PlyVertex> vertices) {
          for (const PlyVertex& vertex : vertices) {
            report_.min = glm::min(report_.min, vertex.position);
            report_.max = glm::max(report_.max, vertex.position);
          }
          addToTopology([&](TopologyCounter& topology) { topology.addVertices(vertices); });
        },
        [&](const PlyFaces& faces) {
          addToTopology([&](TopologyCounter& topology) { topology.addFaces(faces); });
        });
    read_cpu_seconds_ = cpuSeconds() - start - beside;
  }

  void reportDefects() {
    for (const std::string& text : bad_.first)
      addProblem(true, name_ + ": " + text + "; repair the file or build with --skip-bad");
    if (bad_.count > bad_.first.size())
      addProblem(true, name_ + ": " + std::to_string(bad_.count - bad_.first.size()) +
                           " more of this kind; repair the file or build with --skip-bad");
    for (const std::string& text : dropped_.first)
      addProblem(false, name_ + ": " + text + "; a build drops and counts the face");
    if (dropped_.count > dropped_.first.size())
      addProblem(false, name_ + ": " + std::to_string(dropped_.count - dropped_.first.size()) +
                            " more such faces; a build drops and counts them");
  }

  void fail(const std::string& what) {
    addProblem(true, name_ + ": " + what);
    report_.is_readable = false;
  }

  void checkModel() {
    const PlyCounts& counts = report_.counts;
    if (counts.vertices > UINT32_MAX)
      fail(std::to_string(counts.vertices) + " vertices; at most 4294967295 can be indexed: split the model");
    if (counts.triangles == 0) fail("no usable face; export the model again, with its faces");
    if (!report_.skipped_properties.empty())
      addProblem(false, name_ + ": " + skippedInWords(report_.skipped_properties, ignores_face_colours_) +
                            "; a build leaves them out");
    if (counts.unknown_textures > 0)
      addProblem(false,
                 name_ + ": " + unknownTexturesInWords(counts.unknown_textures, report_.textures.size()));
    if (counts.lengthless_normals > 0) addProblem(false, name_ + ": " + lengthlessInWords(counts));
    if (counts.clamped_colours > 0)
      addProblem(false, name_ + ": " + clampedInWords(counts.clamped_colours, face_attributes_));
    if (counts.extra_tokens > 0)
      addProblem(false, name_ + ": " + std::to_string(counts.extra_tokens) +
                            " extra values at the ends of lines; a build ignores them");
    if (counts.trailing_bytes > 0) addProblem(false, name_ + ": " + trailingInWords(counts));
    if (report_.attributes.has(AttributeSet::kTexture) && report_.textures.empty())
      addProblem(false, name_ + ": " + kNoTextureFile);
    if (!report_.topology) return;
    report_.min = report_.topology->used_min;
    report_.max = report_.topology->used_max;
    if (!report_.topology->lattice_problem.empty()) fail(std::string(report_.topology->lattice_problem));
    checkTopology(*report_.topology);
  }

  void checkTopology(const Topology& topology) {
    const auto warn = [&](uint64_t count, const char* one, const char* several, const char* what) {
      if (count > 0) addProblem(false, name_ + ": " + counted(count, one, several) + what);
    };
    warn(topology.unused_vertices, "vertex", "vertices", " that no face uses; a build leaves them out");
    warn(topology.flat_faces, "face", "faces",
         " with fewer than three distinct positions; a build drops and counts them");
    checkLostTriangles({topology.lost_triangles, report_.counts.triangles, topology.lattice_step,
                        topology.used_min, topology.used_max});
    warn(topology.opposed_faces, "face", "faces",
         " whose normals in the file point to the back; a build keeps these normals and lights both sides; "
         "for even shading, remove all normals from the file, so that a build computes them");
    warn(topology.non_manifold_edges, "edge", "edges",
         " of three or more faces; a build keeps them, but simplifies less well around them");
    warn(topology.misoriented_edges, "edge", "edges",
         " between faces of opposite orientation; flip faces for correct shading");
  }

  /// Warns if the memory budget is small for the model. Only a build can tell whether it suffices for the
  /// root node.
  void checkMemory() {
    const uint32_t triangles_per_node = BuildOptions().triangles_per_node;
    const std::string words =
        smallBudgetInWords(budget(), triangles_per_node, report_.counts.triangles <= triangles_per_node);
    if (!words.empty()) addProblem(false, words);
  }

  void checkLostTriangles(const LostTriangles& lost) {
    if (lost.areMost()) return fail(lost.inWords());
    if (lost.lost > 0) addProblem(false, name_ + ": " + lost.inWords());
  }

  void forecast() {
    ForecastInput input;
    input.model = options_.input;
    input.vertices = report_.counts.vertices;
    input.faces = report_.counts.faces;
    input.triangles = report_.counts.triangles;
    input.attributes = takenAttributes(report_.attributes, report_.counts);
    input.double_positions = hasDoublePositions(*report_.header);
    input.face_attributes = face_attributes_;
    input.scan_cpu_seconds = read_cpu_seconds_;
    input.images = images_;
    input.memory_bytes = budget();
    input.threads = options_.threads ? options_.threads : defaultThreads();
    input.temporary_folder = temporaryFolder();
    try {
      report_.forecast = forecastBuild(input);
    } catch (const Error& error) {
      // kInput means that the trial model has no triangle to build. Omit the forecast.
      if (error.code() != ErrorCode::kInput) throw;
    }
  }

  const DoctorOptions options_;
  const std::string name_;
  /// Folder for temporary files; exists only while topology is counted.
  std::optional<TemporaryFolder> folder_;
  std::optional<TopologyCounter> topology_;
  std::optional<PlyReader> reader_;
  Defects bad_, dropped_;
  std::vector<TextureImage> images_;
  double read_cpu_seconds_ = 0;
  AttributeSet face_attributes_;
  bool ignores_face_colours_ = false;
  DoctorReport report_;
};

}  // namespace

DoctorReport examine(const DoctorOptions& options) { return Doctor(options).run(); }

}  // namespace lode::ingest
