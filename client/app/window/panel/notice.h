#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "client/stream/streamer.h"
#include "common/error.h"

namespace lode::app {

/// A line over the picture on how the stream fares, with what to do where something can be done.
struct Notice {
  enum class Kind : uint8_t {
    kNone,
    kHint,     ///< all is well
    kTrouble,  ///< it may pass by itself, or there is less to see than asked for
    kFailure,  ///< it will not
  };
  Kind kind = Kind::kNone;
  std::string text;

  bool operator==(const Notice&) const = default;
};

/// How much of the newest cut is on the GPU.
enum class OnGpu : uint8_t { kNotYetAll, kAll, kFull };

/// The gravest that there is to say. @param offline  only the cache is asked.
Notice noticeOf(const stream::StreamStatus& status, bool offline, OnGpu on_gpu);
/// What a build has warned of, in few lines: the first of it, and how many more are on stderr.
std::string warningOf(std::span<const std::string> warnings);
/// Which models a scene is shown without: the first three, and how many more are on stderr.
std::string missingText(std::span<const std::string> missing);
/// That nothing could be opened, and how to close the window.
Notice noticeOf(const Error& error);

}  // namespace lode::app
