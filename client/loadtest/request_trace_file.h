#pragma once

#include <filesystem>
#include <string_view>

#include "client/loadtest/request_trace.h"
#include "common/io/atomic_file.h"

namespace lode::app {

constexpr uint64_t kMaxTraceFileBytes = 256ull << 20;
constexpr size_t kMaxTracedRequests = 1'000'000;

constexpr uint32_t kTraceVersion = 2;  ///< of the format; 1 had neither it nor the build's name

/// A trace as JSON: {"version": 2, "build_id": "<32 hexadecimal digits>", "duration_s": 20, "step": 0.001,
/// "requests": [{"t": 0, "blob": 7, "bytes": 900, "name":
/// "<32 hexadecimal digits>", "class": 0, "px": 8.5, "mesh": {"triangles": 90, "vertices": 60, "attributes":
/// 1, "box": [0, 0, 0, 9, 9, 9]} or "tile": {"size": [512, 512], "tail": 0} or neither, of pages}]}.
std::string toJson(const RequestTrace& trace);

/// @param source  names the text in errors. @throws Error kInput or kLimit, naming the request and the
/// remedy.
RequestTrace parseRequestTrace(std::string_view json, std::string_view source);

/// Writes the file and commits it. @throws Error kIo.
void writeRequestTrace(AtomicFile file, const RequestTrace& trace);
RequestTrace readRequestTrace(const std::filesystem::path& file);

}  // namespace lode::app
