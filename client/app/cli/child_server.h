#pragma once

#include <chrono>
#include <csignal>
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

/// A lodestreamd child process that serves one store on a loopback port. The server ends when this object is
/// destroyed or the thread that created it ends. Ctrl-C in the terminal does not reach the server, so the
/// server keeps serving until the client ends. The server requires a random token, because other users of the
/// machine can reach its port.
class ChildServer {
 public:
  /// Starts the server and waits until it is ready. @throws Error kIo with the child's message if the server
  /// fails, or if `stop` is requested.
  explicit ChildServer(const std::filesystem::path& store, const std::stop_token& stop = {});

  /// Makes the server open the store again if its file has changed. Does not wait for the server.
  void reload() const noexcept { process_.signal(SIGHUP); }
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
  /// Connection options; contain the child server's token if there is a child server.
  stream::StreamOptions options;
  std::unique_ptr<ChildServer> child;  ///< server of a local file; must outlive the connection
  std::filesystem::path file;  ///< path of the local file as the user wrote it; empty for a model on a server
  FileLock in_use;             ///< lock that keeps other programs from removing the cached store
  std::vector<std::string> warnings = {};  ///< warnings of the store's build
  bool is_preview = false;                 ///< the store is only a preview of a PLY file
};

/// Resolves a target: builds the store of a PLY file if necessary, and starts a child server for a local
/// file.
/// @param options   options of the connection.
/// @param announce  true to print the progress of a build on stderr.
/// @param stop      stop token; a stop request aborts the build or the server's start, and the function
///                  throws an Error.
/// @throws Error.
ResolvedTarget resolveTarget(const Target& target, stream::StreamOptions options, bool announce,
                             std::stop_token stop = {});
/// Starts a child server for a store of a file. @param file  path of the file as the user wrote it.
ResolvedTarget serveStore(BuiltStore store, const std::filesystem::path& file, stream::StreamOptions options,
                          const std::stop_token& stop = {});

/// Waits until the model of a target is open. @throws the errors of stream::Streamer::waitForModel(), with
/// the name of the target's file added.
ModelSummary openModel(stream::Streamer& streamer, const ResolvedTarget& target,
                       std::chrono::milliseconds timeout, std::stop_token stop = {});

}  // namespace lode::app
