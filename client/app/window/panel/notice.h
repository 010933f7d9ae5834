#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "client/core/view/view.h"
#include "client/stream/streamer.h"
#include "common/error.h"

namespace lode::app {

/// A line over the picture: the state of the stream and, if the user can do something, what to do.
struct Notice {
  enum class Kind : uint8_t {
    kNone,
    kHint,     ///< information
    kTrouble,  ///< temporary, or less detail than requested
    kFailure,  ///< permanent
  };
  Kind kind = Kind::kNone;
  std::string text;

  bool operator==(const Notice&) const = default;
};

/// How much of the newest cut is on the GPU.
enum class OnGpu : uint8_t { kNotYetAll, kAll, kFull };

/// Returns the most serious notice that applies. @param offline  only the cache is used.
Notice noticeOf(const stream::StreamStatus& status, bool offline, OnGpu on_gpu);
/// Summarizes the warnings of a build: the first one and the number of others, which are on stderr.
std::string warningOf(std::span<const std::string> warnings);
/// Summarizes the missing models of a scene: the first three and the number of others, which are on stderr.
std::string missingText(std::span<const std::string> missing);
/// Reports that the target could not be opened, and how to close the window.
Notice noticeOf(const Error& error);

/// Describes a build stage by name and number: "sort, 3 of 6". A stage that only some models need has the
/// number of the stage before it. Returns unknown names unchanged.
std::string describeStage(std::string_view stage);

/// Says that the model is outside the view or only a dot, and which key helps. Empty if the model is visible.
std::string_view lostSightText(const core::ModelBox& model, const core::View& view);

}  // namespace lode::app
