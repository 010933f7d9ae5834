#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>
#include <string_view>

namespace lode::app {

/// Told of a build's stage and how much of it is done, 0..1, on the thread that builds.
using BuildWatch = std::function<void(std::string_view stage, double fraction)>;

/// The store of a PLY file: built into the XDG cache, unless it is there and neither the file nor an image
/// that it names nor the builder has changed since. Another program that builds it is waited for. Warnings of
/// the build go to stderr each time.
/// @param announce  progress goes to stderr if that is a terminal.
/// @param stop      ends the wait or the build, which then counts as failed.
/// @param watch     told of the progress, which then does not go to stderr.
/// @throws Error.
std::filesystem::path builtStore(const std::filesystem::path& ply, bool announce, const std::stop_token& stop,
                                 const BuildWatch& watch);

}  // namespace lode::app
