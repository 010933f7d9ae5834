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
  uint64_t memory_bytes = 0;  ///< memory budget of the build to forecast; 0: defaultMemoryBytes()
  unsigned threads = 0;       ///< threads of the build to forecast; 0: one per core
  /// Folder for the forecast's trial build; empty: the system's folder.
  std::filesystem::path temporary_folder;
};

struct DoctorReport {
  struct Problem {
    bool is_fatal = false;  ///< the problem makes a build without --skip-bad fail
    std::string text;       ///< the problem, its place and a remedy
  };
  struct Texture {
    std::string name;
    bool is_found = false;
  };
  std::optional<PlyHeader> header;  ///< empty if the header is unreadable
  uint64_t file_bytes = 0;
  AttributeSet attributes;
  PlyCounts counts;  ///< counts as with --skip-bad; if reading failed, up to that point
  std::vector<std::string> skipped_properties;  ///< properties that a build ignores; see PlyReader
  std::vector<Texture> textures;
  glm::dvec3 min{0}, max{0};  ///< box of the vertices that faces use; without topology, box of all vertices
  std::optional<Topology> topology;  ///< empty if the body is unreadable or has too many vertices to index
  std::vector<Problem> problems;     ///< the first few problems of each kind, then the number of the others
  bool is_readable = false;          ///< a build with --skip-bad would succeed
  bool is_buildable = false;         ///< a build without --skip-bad would succeed, too
  std::optional<BuildForecast> forecast;  ///< present only if the file is readable
};

/// Examines a PLY file: its content, its problems, and the cost of a build. Uses memory up to the budget,
/// plus two bits per vertex. Topology uses about 45 bytes of temporary files per triangle.
/// @throws Error kIo if the file does not exist. The report contains problems inside the file.
DoctorReport examine(const DoctorOptions& options);

}  // namespace lode::ingest
