#pragma once

#include <string>

#include "client/app/cli/common_options.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Whether a view is seen within the error that was asked for, and no tile of a texture that it sees is lost
/// for good: that is as good a picture as an engine can give, but not the one that was asked for.
bool hasConverged(const stream::StreamStatus& status, float pixels);

/// Says why a view has not converged and what to do. @param where  what did not, such as "MODEL at key 2".
/// @throws Error always.
[[noreturn]] void refuseUnconverged(const std::string& where, const stream::StreamStatus& status,
                                    const CommonOptions& options);

/// Warns on stderr of what a view that has converged does without: parts that the server does not have, and
/// tiles of textures that the memory budget had no room for.
void warnOfGaps(const stream::StreamStatus& status, const CommonOptions& options);

}  // namespace lode::app
