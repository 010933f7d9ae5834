#pragma once

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "client/stream/streamer.h"
#include "server/serve/server.h"
#include "tests/integration/programs/programs.h"
#include "tests/support/synthetic_store.h"
#include "tests/support/work_folder.h"

namespace lode::test {

inline stream::StreamOptions threads(unsigned count) {
  stream::StreamOptions options;
  options.decode_threads = count;
  return options;
}

/// A server with two threads that serves a closed model "a" on loopback.
class Streaming : public testing::Test {
 protected:
  Streaming() {
    writeModel(folder_ / "a.lode", 1);
    startServer();
  }
  ~Streaming() override { stopServer(); }

  static void writeModel(const std::filesystem::path& file, uint32_t seed) {
    SyntheticModel model =
        makeModel(makeSphere(96, 64, {.attributes = {AttributeSet::kColour}, .extent = 4000, .seed = seed}),
                  {.leaf_triangles = 200});
    writeStore(file, model);
  }

  /// Replaces the model by another build with the same lattice.
  void replaceModel(uint32_t seed) {
    writeModel(folder_ / "next.lode", seed);
    std::filesystem::rename(folder_ / "next.lode", folder_ / "a.lode");
    server_->reload();
  }

  /// Starts the server: the first time on a free port, later always on the same port.
  void startServer() {
    serve::ServeOptions options;
    options.stores = {folder_ / store_};
    options.listen = "127.0.0.1:" + std::to_string(served_.address.port);
    options.threads = 2;
    options.drain_deadline = std::chrono::milliseconds(100);
    options.max_connections = max_connections_;
    server_.emplace(options);
    served_ = {{"127.0.0.1", server_->port()}, "a"};
    thread_ = std::thread([this] { server_->run(); });
  }

  void stopServer() {
    if (server_) server_->stop();
    if (thread_.joinable()) thread_.join();
    server_.reset();
  }

  /// Returns a view from a camera that orbits close to the model.
  static core::View viewAt(int step, const ModelSummary& model) {
    core::CameraPath path = core::framingCamera(model);
    core::CameraKey& key = path.keys.front();
    const double angle = 0.7 * step;
    key.eye = key.target + glm::length(key.eye - key.target) * (0.4 + 0.1 * (step % 5)) *
                               glm::dvec3(std::cos(angle), 0.2, std::sin(angle));
    return core::toView(key, path.fov_y_deg, 640, 480, model);
  }

  const WorkFolder folder_;
  std::string store_ = "a.lode";
  uint32_t max_connections_ = 100;
  std::optional<serve::Server> server_;
  stream::ServedModel served_{{"127.0.0.1", 0}, "a"};
  std::thread thread_;
};

}  // namespace lode::test
