// Tests of a server that is killed repeatedly while clients stream. Each client continues with the next
// server.

#include <atomic>
#include <cmath>
#include <csignal>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/app/cli/cut_export.h"
#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "client/stream/streamer.h"
#include "tests/integration/programs/programs.h"
#include "tests/support/synthetic_store.h"

namespace lode::test {
namespace {

using namespace std::chrono_literals;
using stream::Streamer;
using stream::StreamStatus;

constexpr float kThresholdPx = 0.5f;

class KilledServer : public testing::Test {
 protected:
  KilledServer() {
    SyntheticModel model = makeModel(
        makeSphere(96, 64, {.attributes = {AttributeSet::kColour}, .extent = 4000}), {.leaf_triangles = 200});
    writeStore(folder_ / "a.lode", model);
    start();
  }

  /// Starts the server: the first time on a free port, later always on the same port.
  void start() {
    const std::string listen = "127.0.0.1:" + std::to_string(served_.address.port);
    server_ = std::make_unique<Program>(
        "lodestreamd", std::vector<std::string>{"serve", folder_ / "a.lode", "--listen", listen});
    const auto ready = nlohmann::json::parse(server_->readLine(), nullptr, false);
    ASSERT_TRUE(ready.is_object()) << "the server did not start";
    const auto address = ready["listen"].get<std::string>();
    served_.address.port = static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
  }
  void killAndStart() {
    server_->signal(SIGKILL);
    EXPECT_EQ(server_->wait().status, 128 + SIGKILL);
    start();
  }

  std::unique_ptr<Streamer> connect() const {
    stream::StreamOptions options;
    options.decode_threads = 1;
    auto streamer = std::make_unique<Streamer>(served_, options);
    streamer->waitForModel(kPatience);
    return streamer;
  }

  /// Returns a view close to the model. Each step looks from another side.
  static core::View viewAt(int step, const ModelSummary& model) {
    core::CameraPath path = core::framingCamera(model);
    core::CameraKey& key = path.keys.front();
    const double angle = 0.7 * step;
    key.eye = key.target + glm::length(key.eye - key.target) * (0.4 + 0.1 * (step % 5)) *
                               glm::dvec3(std::cos(angle), 0.2, std::sin(angle));
    return core::toView(key, path.fov_y_deg, 640, 480, model);
  }

  Mesh cutOf(Streamer& streamer, const core::View& view) const {
    streamer.setView(view, kThresholdPx);
    const StreamStatus status = streamer.waitUntilSettled(kPatience);
    EXPECT_FALSE(status.ended) << status.failure;
    EXPECT_TRUE(status.settled && status.cut && status.cut->converged);
    return status.cut ? app::weldCut(*status.cut, streamer.model()->attributes) : Mesh();
  }

  /// Kills the server at random moments while four clients change views. Compares their final cuts with the
  /// cut of an undisturbed client.
  void killManyTimes(int kills, uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    std::vector<std::unique_ptr<Streamer>> clients(4);
    int step = 0;
    for (int kill = 0; kill < kills && !HasFailure(); ++kill) {
      if (kill % 20 == 0)  // the clients' caches are full, so start again with empty caches
        for (auto& client : clients) client = connect();
      for (const auto& client : clients) client->setView(viewAt(++step, *client->model()), kThresholdPx);
      std::this_thread::sleep_for(part(random) * 20ms);
      killAndStart();
      const core::View view = viewAt(kill, *clients[0]->model());
      const Mesh expected = cutOf(*connect(), view);
      for (const auto& client : clients) EXPECT_TRUE(cutOf(*client, view) == expected) << "kill " << kill;
    }
  }

  const WorkFolder folder_;
  stream::ServedModel served_{{"127.0.0.1", 0}, "a"};
  std::unique_ptr<Program> server_;
};

TEST_F(KilledServer, losesNoneOfItsClients) { killManyTimes(5, 1); }

using SlowKilledServer = KilledServer;

TEST_F(SlowKilledServer, losesNoneOfItsClientsInTwoHundredKillsUnderLoad) { killManyTimes(200, 2); }

}  // namespace
}  // namespace lode::test
