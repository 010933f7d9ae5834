// Tests of the reports of loadtest, with a server that answers and with a server that does not.

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "programs.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

/// A server that accepts connections and sends nothing.
class SilentServer {
 public:
  SilentServer() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(socket_, 8), 0);
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~SilentServer() { close(socket_); }
  SilentServer(const SilentServer&) = delete;
  SilentServer& operator=(const SilentServer&) = delete;

  std::string url() const { return "lode://127.0.0.1:" + std::to_string(port_) + "/model"; }
  void waitForAConnection() const {
    pollfd waiting{socket_, POLLIN, 0};
    EXPECT_EQ(poll(&waiting, 1, static_cast<int>(std::chrono::milliseconds(kPatience).count())), 1);
  }
  /// Sends a text to the next connection, and closes it.
  void sayOnce(std::string_view text) const {
    waitForAConnection();
    const int client = accept(socket_, nullptr, nullptr);
    EXPECT_EQ(send(client, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
    shutdown(client, SHUT_WR);
    char asked[4096];
    while (recv(client, asked, sizeof asked, 0) > 0) continue;
    close(client);
  }

 private:
  int socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  uint16_t port_ = 0;
};

class Loadtest : public testing::Test {
 protected:
  Json run(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"loadtest", server_.url("small"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lodestream(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Json::parse(outcome.out);
  }

  /// Writes a camera path of a tenth of a second. Clients replay the path every second.
  std::string shortPath() {
    const std::filesystem::path file = folder_ / "path.json";
    std::ofstream(file) << R"({"fov_y_deg": 45, "keys": [
      {"t": 0, "eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]},
      {"t": 0.1, "eye": [0, 0, 3], "target": [0, 0, 0], "up": [0, 1, 0]}]})";
    return file.string();
  }

  WorkFolder folder_;
  RunningServer server_{{makeSmallStore(folder_)}};
};

TEST_F(Loadtest, answersEveryClientWithoutAnError) {
  for (const auto& decode : {std::vector<std::string>{}, {"--decode-off"}}) {
    std::vector<std::string> arguments{"--clients", "20", "--seconds", "2", "--threads", "2"};
    arguments.insert(arguments.end(), decode.begin(), decode.end());
    const Json told = run(arguments);
    EXPECT_EQ(told["clients"], 20);
    EXPECT_EQ(told["errors"], 0) << told["first_error"];
    EXPECT_EQ(told["first_image_ms"]["count"], 20);
    EXPECT_GT(told["blobs"], 40);
    EXPECT_GT(told["bytes"], told["blobs"]);
    EXPECT_GT(told["latency_ms"]["visible"]["count"], 0);
    EXPECT_LE(told["latency_ms"]["visible"]["p50"], told["latency_ms"]["visible"]["p99"]);
    EXPECT_LE(told["latency_ms"]["visible"]["p99"], told["latency_ms"]["visible"]["max"]);
  }
}

TEST_F(Loadtest, endsInTimeWithManyClients) {
  const Json told = run({"--clients", "300", "--seconds", "2", "--decode-off"});
  EXPECT_EQ(told["errors"], 0) << told["first_error"];
  EXPECT_EQ(told["first_image_ms"]["count"], 300);
}

TEST_F(Loadtest, reportsWhenThePicturesOfFullClientsConverge) {
  for (const char* path : {"orbit", "fly", "walk"}) {
    const Json told = run({"--full", "--clients", "5", "--seconds", "2", "--ramp", "0.5", "--path", path});
    EXPECT_EQ(told["errors"], 0) << told["first_error"];
    EXPECT_EQ(told["started"], 5);
    EXPECT_EQ(told["first_image_ms"]["count"], 5);
    EXPECT_EQ(told["converged_ms"]["count"], 5);
    EXPECT_GE(told["converged_ms"]["p50"], told["first_image_ms"]["p50"]);
    EXPECT_LT(told["converged_ms"]["p50"], 1400);
    EXPECT_GT(told["latency_ms"]["visible"]["count"], 0);
    EXPECT_LT(told["seconds_far_off"], told["seconds_looked"]);
    EXPECT_GT(told["seconds_looked"], 5);
  }
}

TEST_F(Loadtest, alternatesBetweenModelsOfSeveralServers) {
  const RunningServer other{{folder_ / "small.lode"}};
  for (const auto& kind : {std::vector<std::string>{"--full"}, {"--path", "walk"}}) {
    std::vector<std::string> arguments{other.url("small"), "--clients", "6", "--seconds", "2",
                                       "--ramp",           "0.5"};
    arguments.insert(arguments.end(), kind.begin(), kind.end());
    const Json told = run(arguments);
    EXPECT_EQ(told["errors"], 0) << told["first_error"];
    EXPECT_EQ(told["first_image_ms"]["count"], 6);
    if (kind.front() == "--full") continue;
    ASSERT_EQ(told["traces"].size(), 8u);
    for (size_t i = 1; i < 8; ++i)
      EXPECT_NE(told["traces"][i]["model"], told["traces"][i - 1]["model"]) << "the next client's";
  }
}

TEST_F(Loadtest, startsItsClientsWithinTheRamp) {
  EXPECT_LT(run({"--clients", "10", "--seconds", "2", "--ramp", "100", "--decode-off"})["started"], 3);
  EXPECT_EQ(run({"--clients", "10", "--seconds", "1", "--ramp", "0", "--decode-off"})["started"], 10);
}

TEST_F(Loadtest, requestsLessWithThinkTime) {
  const std::vector<std::string> arguments{"--clients", "4", "--seconds", "3",
                                           "--ramp",    "0", "--camera",  shortPath()};
  std::vector<std::string> thinking = arguments;
  thinking.insert(thinking.end(), {"--think", "1000"});
  EXPECT_LT(run(thinking)["blobs"], run(arguments)["blobs"]);
}

TEST_F(Loadtest, sortsErrorsByKind) {
  const std::string url = server_.url("small");
  server_.stop();
  const Outcome outcome =
      lodestream({"loadtest", url, "--full", "--clients", "3", "--seconds", "1", "--ramp", "0", "--json"});
  EXPECT_EQ(outcome.status, 1);
  expectOneLine(outcome.err);
  const Json told = Json::parse(outcome.out);
  EXPECT_NE(outcome.err.find(told.at("first_error")), std::string::npos) << outcome.err;
  EXPECT_GE(told["errors"], 3) << "each of the three clients tries at least once";
  EXPECT_EQ(told["errors_by_kind"], Json({{"network", told["errors"]}}));
}

TEST_F(Loadtest, printsItsResultsWhenInterrupted) {
  const SilentServer silent;
  Program test("lodestream", {"loadtest", silent.url(), "--full", "--clients", "1", "--seconds", "600",
                              "--ramp", "0", "--json"});
  silent.waitForAConnection();
  test.signal(SIGINT);
  const Outcome outcome = test.wait();
  EXPECT_EQ(outcome.status, 128 + SIGINT);
  const Json told = Json::parse(outcome.out, nullptr, false);
  EXPECT_EQ(told.value("interrupted", false), true);
  EXPECT_EQ(told.value("started", 0), 1);
}

/// A running load test of a store file.
class LoadtestOfAFile : public testing::Test {
 protected:
  LoadtestOfAFile() { silent_.waitForAConnection(); }
  /// Returns the server processes that the load test has started.
  Processes servers() const { return processesNaming(store_.string() + " --listen"); }

  WorkFolder folder_;
  const std::filesystem::path store_ = makeSmallStore(folder_);
  const SilentServer silent_;  // server to which the clients connect
  Program test_{
      "lodestream",
      {"loadtest", store_, silent_.url(), "--full", "--clients", "2", "--seconds", "600", "--ramp", "0"}};
};

TEST_F(LoadtestOfAFile, runsItsServerInAnotherProcessGroup) {
  ASSERT_EQ(servers().size(), 1u);
  EXPECT_NE(getpgid(servers().begin()->first), getpgrp()) << "terminals signal a process group";
}

TEST_F(LoadtestOfAFile, leavesNoServerBehindWhenKilled) {
  ASSERT_EQ(servers().size(), 1u);
  test_.signal(SIGKILL);
  test_.wait();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!servers().empty() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(servers(), Processes{});
}

TEST_F(Loadtest, refusesIncompatibleOptions) {
  const std::string url = server_.url("small");
  for (const auto& more : {std::vector<std::string>{"--full", "--decode-off"},
                           {url, "--trace", shortPath()},
                           {"--path", "fly", "--camera", shortPath()},
                           {"--path", "fly", "--trace", shortPath()},
                           {"--up", "z"},
                           {"--cache", shortPath()},
                           {"--fps", "10"},
                           {"--pixels", "2", "--trace", shortPath()},
                           {"--offline"}}) {
    std::vector<std::string> arguments{"loadtest", url, "--clients", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lodestream(arguments);
    EXPECT_EQ(outcome.status, 2);
    expectOneLine(outcome.err);
  }
}

TEST_F(Loadtest, reportsAServerThatIsNotLodestreamd) {
  const SilentServer web;
  for (const char* kind : {"--full", "--decode-off"}) {
    Program test("lodestream", {"loadtest", web.url(), kind, "--clients", "1", "--seconds", "1"});
    web.sayOnce("HTTP/1.0 400 Bad Request\r\n\r\n");
    const Outcome outcome = test.wait();
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE((outcome.out + outcome.err).find("is not lodestreamd; check the port"), std::string::npos)
        << outcome.out << outcome.err;
  }
}

TEST_F(Loadtest, failsWithOneLineIfTheServerLacksTheModel) {
  const std::string url = server_.url("nothing");
  expectFailure(lodestream({"loadtest", url, "--clients", "2", "--seconds", "1"}), {"nothing"});
}

}  // namespace
}  // namespace lode::test
