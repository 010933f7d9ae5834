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

/// A lodestreamd child process that serves one store on a loopback port. It ends with this object and with
/// the thread that created it. It ignores a terminal's Ctrl-C, so that it serves until the client has ended.
/// It requires a random token, because other users of the machine can reach its port.
class ChildServer {
 public:
  /// Starts the server and waits until it is ready. @throws Error kIo with the child's message, or if `stop`
  /// is requested.
  explicit ChildServer(const std::filesystem::path& store, const std::stop_token& stop = {});

  const stream::ServedModel& served() const noexcept { return served_; }
  const std::string& token() const noexcept { return token_; }

 private:
  std::string token_;
  ChildProcess process_;
  stream::ServedModel served_;
};

/// A target that a client can connect to.
struct ResolvedTarget {
  stream::ServedModel served;
  stream::StreamOptions options;           ///< with the child server's token, if any
  std::unique_ptr<ChildServer> child;      ///< serves a local file; must outlive the connection
  std::filesystem::path file;              ///< as the user named it; empty for a model on a server
  FileLock in_use;                         ///< keeps a store in the cache from removal
  std::vector<std::string> warnings = {};  ///< warnings of its build
};

/// Resolves a target: builds the store of a PLY file if necessary, and starts a child server for a local
/// file.
/// @param options   for the connection.
/// @param announce  prints progress of a build on stderr if that is a terminal.
/// @param stop      aborts a build or the start of the server: throws Error.
/// @param watch     receives the progress of a build instead of stderr.
/// @throws Error.
ResolvedTarget resolveTarget(const Target& target, stream::StreamOptions options, bool announce,
                             std::stop_token stop = {}, const BuildWatch& watch = {});

/// Waits until the model of a target is open. @throws Error as stream::Streamer::waitForModel, with the name
/// of the target's file.
ModelSummary openModel(stream::Streamer& streamer, const ResolvedTarget& target,
                       std::chrono::milliseconds timeout, std::stop_token stop = {});

}  // namespace lode::app
