#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/inspect/build_forecast.h"
#include "server/ingest/inspect/topology.h"
#include "server/ingest/ply/ply_reader.h"

namespace lode::ingest {

struct DoctorOptions {
  std::filesystem::path input;
  uint64_t memory_bytes = 0;               ///< budget of the build to forecast; 0: defaultMemoryBytes()
  unsigned threads = 0;                    ///< of the build to forecast; 0: one a core
  std::filesystem::path temporary_folder;  ///< for the trial of the forecast; empty: the system's
};

struct DoctorReport {
  struct Problem {
    bool is_fatal = false;  ///< a build without --skip-bad fails
    std::string text;       ///< what, where, what to do
  };
  struct Texture {
    std::string name;
    bool is_found = false;
  };
  std::optional<PlyHeader> header;  ///< nothing if it cannot be read
  uint64_t file_bytes = 0;
  AttributeSet attributes;
  PlyCounts counts;                             ///< with skip_bad; as far as the file could be read
  std::vector<std::string> skipped_properties;  ///< see PlyReader; a build leaves them out
  std::vector<Texture> textures;
  glm::dvec3 min{0}, max{0};         ///< of the vertices that faces use; of all where topology is not counted
  std::optional<Topology> topology;  ///< nothing if the body cannot be read, or has more vertices than can be
                                     ///< indexed
  std::vector<Problem> problems;     ///< the first few of each kind, then what is left as a count
  bool is_readable = false;          ///< a build with --skip-bad succeeds
  bool is_buildable = false;         ///< one without succeeds, too
  std::optional<BuildForecast> forecast;  ///< where the file is readable
};

/// Says what is in a PLY file, all that is wrong with it, and what a build will cost. Memory: up to
/// the budget, and two bits a vertex; topology is counted by way of temporary files, about 45 bytes a
/// triangle.
/// @throws Error kIo if there is no such file; what is wrong inside it is in the report.
DoctorReport examine(const DoctorOptions& options);

}  // namespace lode::ingest
