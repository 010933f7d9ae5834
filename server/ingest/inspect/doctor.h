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
  /// Folder to search first for images; empty: only the input's folder.
  std::filesystem::path textures_folder = {};
};

struct DoctorReport {
  struct Problem {
    bool is_fatal = false;  ///< true if a build without --skip-bad fails because of the problem
    std::string text;       ///< the problem, its place and a remedy
  };
  struct Texture {
    std::string name;
    std::filesystem::path path;  ///< path of the image; empty if no file was found
  };
  std::optional<PlyHeader> header;  ///< empty if the header is unreadable
  uint64_t file_bytes = 0;
  AttributeSet attributes;
  /// Counts that a build with --skip-bad would report; if reading failed, the counts up to the failure.
  PlyCounts counts;
  std::vector<std::string> skipped_properties;  ///< properties that a build ignores; see PlyReader
  std::vector<Texture> textures;
  /// Bounding box of the vertices that faces use, or of all vertices if `topology` is empty.
  glm::dvec3 min{0}, max{0};
  std::optional<Topology> topology;  ///< empty if the body is unreadable or has too many vertices to index
  std::vector<Problem> problems;     ///< first few problems of each kind, then the number of further problems
  bool is_readable = false;          ///< true if a build with --skip-bad would succeed
  bool is_buildable = false;         ///< true if a build without --skip-bad would succeed too
  std::optional<BuildForecast> forecast;  ///< present only if the file is readable
};

/// Examines a PLY file: its content, its problems, and the cost of a build. Uses memory up to the budget plus
/// two bits per vertex. Counting the topology takes temporary files of about 45 bytes per triangle.
/// @throws Error kIo if the file does not exist. Problems inside the file are in the report.
DoctorReport examine(const DoctorOptions& options);

}  // namespace lode::ingest
