#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "client/app/cli/built_store.h"
#include "client/app/cli/child_process.h"
#include "client/app/cli/target.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// The sibling lodestreamd as a child process that serves one store on a port of loopback; it ends with this
/// object, and with the thread that made it however that ends. A terminal's
/// Ctrl-C is not for it, so that it serves on while the client comes to its end. It knows one token, made for
/// it: other users of the machine can reach its port.
class ChildServer {
 public:
  /// Starts it and waits until it is ready. @throws Error kIo naming what failed and what the child said, or
  /// when it is stopped.
  explicit ChildServer(const std::filesystem::path& store, const std::stop_token& stop = {});

  const stream::ServedModel& served() const noexcept { return served_; }
  const std::string& token() const noexcept { return token_; }

 private:
  std::string token_;
  ChildProcess process_;
  stream::ServedModel served_;
};

/// A target that can be connected to: starts a child server where the target is a file, after building a PLY
/// where that was not done before.
struct ResolvedTarget {
  stream::ServedModel served;
  stream::StreamOptions options;           ///< with the token of the child, if there is one
  std::unique_ptr<ChildServer> child;      ///< keep it as long as the connection
  std::filesystem::path file;              ///< as the user named it; empty: on a server
  FileLock in_use;                         ///< of a store in the cache
  std::vector<std::string> warnings = {};  ///< of its build
};

/// @param options   for the connection.
/// @param announce  progress of a build goes to stderr if that is a terminal.
/// @param stop      ends a child under way, which then counts as failed.
/// @param watch     told of the progress of a build, which then does not go to stderr.
/// @throws Error.
ResolvedTarget resolveTarget(const Target& target, stream::StreamOptions options, bool announce,
                             std::stop_token stop = {}, const BuildWatch& watch = {});

/// Waits until the model of a target is open. @throws Error as stream::Streamer::waitForModel, naming the
/// target's file.
ModelSummary openModel(stream::Streamer& streamer, const ResolvedTarget& target,
                       std::chrono::milliseconds timeout, std::stop_token stop = {});

}  // namespace lode::app
