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

/// A lodestreamd child process that serves one store on a loopback port. The server ends with this object and
/// with the thread that created this object. The server ignores Ctrl-C in the terminal, so that it serves
/// until the client has ended. The server requires a random token, because other users of the machine can
/// reach its port.
class ChildServer {
 public:
  /// Starts the server and waits until it is ready. @throws Error kIo with the child's message if the server
  /// fails, or if `stop` is requested.
  explicit ChildServer(const std::filesystem::path& store, const std::stop_token& stop = {});

  const stream::ServedModel& served() const noexcept { return served_; }
  const std::string& token() const noexcept { return token_; }

 private:
  std::string token_;
  ChildProcess process_;
  stream::ServedModel served_;
};

/// A target to which a client can connect.
struct ResolvedTarget {
  stream::ServedModel served;
  stream::StreamOptions options;           ///< connection options, with the token of the child server if
                                           ///< a child server runs
  std::unique_ptr<ChildServer> child;      ///< server of a local file; must outlive the connection
  std::filesystem::path file;              ///< local file as the user named it; empty for a model on a server
  FileLock in_use;                         ///< lock that keeps other programs from removing the store
  std::vector<std::string> warnings = {};  ///< warnings of the build of the store
};

/// Resolves a target: builds the store of a PLY file if necessary, and starts a child server for a local
/// file.
/// @param options   options of the connection.
/// @param announce  true prints the progress of a build on stderr, if stderr is a terminal.
/// @param stop      a stop request aborts a build or the start of the server; the function then throws an
/// Error.
/// @param watch     if set, receives the progress of a build instead of stderr.
/// @throws Error.
ResolvedTarget resolveTarget(const Target& target, stream::StreamOptions options, bool announce,
                             std::stop_token stop = {}, const BuildWatch& watch = {});

/// Waits until the model of a target is open. @throws the errors of stream::Streamer::waitForModel(), with
/// the name of the target's file added.
ModelSummary openModel(stream::Streamer& streamer, const ResolvedTarget& target,
                       std::chrono::milliseconds timeout, std::stop_token stop = {});

}  // namespace lode::app
