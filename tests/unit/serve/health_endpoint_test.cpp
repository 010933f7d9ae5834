#include "server/serve/ops/health_endpoint.h"

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::serve {
namespace {

using asio::ip::tcp;

class HealthEndpointTest : public testing::Test {
 protected:
  ~HealthEndpointTest() override {
    context_.stop();
    thread_.join();
  }
  tcp::socket connect() {
    const std::string address = endpoint_.address();
    const auto port = static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
    tcp::socket socket(client_);
    socket.connect({asio::ip::address_v4::loopback(), port});
    return socket;
  }
  static std::string readAll(tcp::socket& socket) {
    std::string answer;
    asio::error_code end;
    asio::read(socket, asio::dynamic_buffer(answer), end);
    return answer;
  }
  std::string ask(const std::string& request) {
    tcp::socket socket = connect();
    asio::write(socket, asio::buffer(request));
    return readAll(socket);
  }
  std::string get(const std::string& path) { return ask("GET " + path + " HTTP/1.1\r\nHost: x\r\n\r\n"); }

  asio::io_context context_, client_;
  std::atomic<bool> ready_{true};
  HealthEndpoint endpoint_{
      context_, "127.0.0.1:0", {[] { return std::string("figures 1\n"); }, [this] { return ready_.load(); }}};
  std::thread thread_{[this] { context_.run(); }};
};

TEST_F(HealthEndpointTest, givesTheMetrics) {
  const std::string answer = get("/metrics");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 ")) << answer;
  EXPECT_NE(answer.find("text/plain; version=0.0.4"), std::string::npos);
  EXPECT_TRUE(answer.ends_with("\r\n\r\nfigures 1\n"));
}

TEST_F(HealthEndpointTest, isAliveAndReadyUntilItStops) {
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 200 "));
  ready_ = false;
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 503 "));
  EXPECT_TRUE(get("/healthz").starts_with("HTTP/1.1 200 "));
}

TEST_F(HealthEndpointTest, refusesOtherPathsAndMethods) {
  EXPECT_TRUE(get("/").starts_with("HTTP/1.1 404 "));
  EXPECT_TRUE(ask("POST /metrics HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405 "));
}

TEST_F(HealthEndpointTest, closesOnAnythingButHttp) { EXPECT_EQ(ask("nonsense\r\n\r\n"), ""); }

TEST_F(HealthEndpointTest, answersTheNextWhileOthersSayNothing) {
  std::vector<tcp::socket> silent;
  for (int i = 0; i < 15; ++i) silent.push_back(connect());
  EXPECT_TRUE(get("/healthz").starts_with("HTTP/1.1 200 "));
}

TEST_F(HealthEndpointTest, answersAtOnceDespiteManySilentClients) {
  std::vector<tcp::socket> silent;
  for (int i = 0; i < 40; ++i) silent.push_back(connect());
  EXPECT_TRUE(get("/healthz").starts_with("HTTP/1.1 200 "));
  EXPECT_EQ(readAll(silent.front()), "") << "who has waited longest had to go";
}

TEST_F(HealthEndpointTest, acceptsMoreClientsOnceSomeHaveLeft) {
  {
    std::vector<tcp::socket> silent;
    for (int i = 0; i < 40; ++i) silent.push_back(connect());
  }
  EXPECT_TRUE(get("/healthz").starts_with("HTTP/1.1 200 "));
}

TEST_F(HealthEndpointTest, failsWithTheNameOfTheOptionIfItsAddressIsInUse) {
  asio::io_context other;
  try {
    const HealthEndpoint second(other, endpoint_.address(), {});
    FAIL() << "listens twice";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_NE(std::string(error.what()).find("--metrics"), std::string::npos);
  }
}

TEST(HealthRequest, isAwaitedUntilItsHeadIsComplete) {
  const std::string request = "GET /metrics?x=1 HTTP/1.1\r\nHost: here\r\n\r\n";
  for (size_t length = 0; length < request.size(); ++length)
    EXPECT_FALSE(parseHealthRequest(std::string_view(request).substr(0, length)));
  const auto parsed = parseHealthRequest(request);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->path, "/metrics");
  EXPECT_TRUE(parsed->known_method);
  EXPECT_FALSE(parsed->head_only);
}

TEST(HealthRequest, distinguishesMethods) {
  EXPECT_TRUE(parseHealthRequest("HEAD /healthz HTTP/1.0\r\n\r\n")->head_only);
  EXPECT_FALSE(parseHealthRequest("POST /healthz HTTP/1.1\r\n\r\n")->known_method);
}

TEST(HealthRequest, isRefusedIfTooLongOrNotHttp) {
  for (const char* text : {"hello\r\n\r\n", "GET /\r\n\r\n", "GET / LODE/1\r\n\r\n", "\r\n\r\n"})
    EXPECT_THROW(parseHealthRequest(text), Error) << text;
  EXPECT_THROW(parseHealthRequest(std::string(kMaxHealthRequestBytes, 'x')), Error);
  EXPECT_FALSE(parseHealthRequest(std::string(kMaxHealthRequestBytes - 1, 'x')));
}

TEST(HealthAnswer, hasItsLengthAndEndsTheConnection) {
  const std::string answer = healthAnswer(503, "text/plain", "stopping\n", false);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 503 Service Unavailable\r\n"));
  EXPECT_NE(answer.find("\r\nContent-Length: 9\r\n"), std::string::npos);
  EXPECT_NE(answer.find("\r\nConnection: close\r\n"), std::string::npos);
  EXPECT_TRUE(answer.ends_with("\r\n\r\nstopping\n"));
  EXPECT_TRUE(healthAnswer(200, "text/plain", "alive\n", true).ends_with("\r\n\r\n"));
}

}  // namespace
}  // namespace lode::serve
