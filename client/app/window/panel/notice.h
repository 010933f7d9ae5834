#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "client/core/view/view.h"
#include "client/stream/streamer.h"
#include "common/error.h"

namespace lode::app {

/// A text over the picture that describes the state of the stream. If the user can do something about it, the
/// text says what.
struct Notice {
  enum class Kind : uint8_t {
    kNone,
    kHint,     ///< information without a problem
    kTrouble,  ///< a temporary problem, or less detail than requested
    kFailure,  ///< a permanent problem
  };
  Kind kind = Kind::kNone;
  std::string text;

  bool operator==(const Notice&) const = default;
};

/// Progress of uploading the newest cut to the GPU.
enum class OnGpu : uint8_t {
  kNotYetAll,  ///< parts of the cut are still missing
  kAll,        ///< the whole cut is on the GPU
  kFull        ///< the cut does not fit into the GPU memory
};

/// Returns the most serious notice that applies to a stream's status. @param offline  true if only the cache
/// is used.
Notice noticeOf(const stream::StreamStatus& status, bool offline, OnGpu on_gpu);
/// Describes the warnings of a build. @param all  true to return all of them, a line each; false to return
/// the first and the key that shows all, for one line that may be cut off at its end.
std::string warningOf(std::span<const std::string> warnings, bool all);
/// Describes the missing models of a scene like warningOf().
std::string missingText(std::span<const std::string> missing, bool all);
/// Names the hidden models of a scene: "hidden: a, b"; empty if there are none.
std::string hiddenText(std::span<const std::string> names);
/// Returns a notice that the target could not be opened, with the reason and the key that closes the window.
Notice noticeOf(const Error& error);

/// If the model is outside the view or only a dot, returns a text that says so and names the key that resets
/// the view. Otherwise returns an empty text.
std::string_view lostSightText(const core::ModelBox& model, const core::View& view);

}  // namespace lode::app
