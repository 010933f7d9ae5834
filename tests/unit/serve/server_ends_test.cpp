// Log lines and metrics of connections that ended before their first frame or broke a rule.

#include <ctime>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/support/bytes.h"
#include "tests/support/test_certificate.h"
#include "tests/unit/serve/server_fixture.h"
#include "tests/unit/serve/tls_client.h"

namespace lode::serve {
namespace {

using namespace test;
class ServerEnds : public ServerTest {
 protected:
  ServerEnds() {
    options_.metrics = "127.0.0.1:0";
    options_.log.json = true;
    options_.log.descriptor = log_;
  }
  ~ServerEnds() override {
    stop();
    server_.reset();
    ::close(log_);
  }
  void startUnderTls() {
    options_.tls_certificate = folder_.path() / "chain.pem";
    options_.tls_key = folder_.path() / "key.pem";
    lode::test::writeCertificate(options_.tls_certificate, options_.tls_key);
    start();
  }
  void startBehindABalancer() {
    options_.proxy_protocol = true;
    start();
  }

  /// Returns the log line of the end of the only connection.
  nlohmann::json end() const {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (std::chrono::steady_clock::now() < deadline) {
      std::ifstream log(path_);
      for (std::string line; std::getline(log, line) && !log.eof();) {
        nlohmann::json json = nlohmann::json::parse(line);
        if (json["message"] == "a connection ended") return json;
      }
      std::this_thread::sleep_for(5ms);
    }
    ADD_FAILURE() << "no connection has ended";
    return {};
  }

  /// Returns the value of a metric with labels, or -1 if it is missing.
  double metric(const std::string& sample) const {
    const std::string address = *server_->metricsAddress();
    asio::io_context context;
    asio::ip::tcp::socket socket(context);
    socket.connect({asio::ip::address_v4::loopback(),
                    static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)))});
    asio::write(socket, asio::buffer(std::string("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n")));
    std::string text;
    asio::error_code all_read;
    asio::read(socket, asio::dynamic_buffer(text), all_read);
    const size_t at = text.find("\n" + sample + " ");
    return at == std::string::npos ? -1 : std::stod(text.substr(at + sample.size() + 2));
  }
  double refused(const std::string& reason) const {
    return metric("lodestream_connections_refused_total{reason=\"" + reason + "\"}");
  }
  double ended(const std::string& reason) const {
    return metric("lodestream_connections_ended_total{reason=\"" + reason + "\"}");
  }
  /// Log line of the end of the only connection.
  void expectCountedOnce(const std::string& reason) const {
    end();
    EXPECT_EQ(metric("lodestream_connections_accepted_total"), 1);
    EXPECT_EQ(refused(reason), 1);
    EXPECT_EQ(ended(reason), 1);
    EXPECT_EQ(ended("broken"), 0);
  }

  const std::filesystem::path path_ = folder_.path() / "log.txt";
  const int log_ = ::open(path_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
};

TEST_F(ServerEnds, aHandshakeThatFailsIsLoggedAsTlsInTheWordsOfOpenSsl) {
  startUnderTls();
  TestClient client = connect();
  client.sendText("GET / HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(end()["reason"], "tls");
  EXPECT_EQ(end()["why"], "http request");
}

TEST_F(ServerEnds, anOldTlsVersionIsLoggedAsUnsupported) {
  startUnderTls();
  const TlsClient client(server_->port(), TLS1_2_VERSION);
  EXPECT_EQ(end()["why"], "unsupported protocol");
}

TEST_F(ServerEnds, aClientThatLeavesInTheHandshakeIsLoggedAsLeaving) {
  startUnderTls();
  { connect().sendText("\x16\x03\x01"); }
  EXPECT_EQ(end()["reason"], "tls");
  EXPECT_EQ(end()["why"], "the other side closed it");
}

TEST_F(ServerEnds, aConnectionWithoutTheBalancersHeaderIsLoggedAsThat) {
  startBehindABalancer();
  TestClient client = connect();
  client.send(proto::Hello{});
  EXPECT_EQ(end()["reason"], "proxy_header");
  EXPECT_NE(end().value("why", "").find("it does not begin with one"), std::string::npos) << end();
}

TEST_F(ServerEnds, aFailedHandshakeAndAWrongHeaderAreMistakesInTheLog) {
  startBehindABalancer();
  connect().sendText("nonsense");
  EXPECT_EQ(end()["kind"], "mistake");
}

TEST_F(ServerEnds, aProtocolMistakeIsLoggedWithTheWordsSentToTheClient) {
  start();
  TestClient client = connect();
  client.open("a");
  client.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "", "test"}, 3);
  std::optional<Received> frame = client.receive();
  while (frame && !frame->is(FrameType::kError)) frame = client.receive();
  ASSERT_TRUE(frame);
  EXPECT_EQ(end()["reason"], "mistake");
  EXPECT_EQ(end().value("why", ""), proto::decode<proto::ErrorMessage>(frame->body).message);
}

TEST_F(ServerEnds, anInvalidFrameIsLoggedWithTheWordsSentToTheClient) {
  start();
  TestClient client = connect();
  client.sendText("GET / HTTP/1.1\r\n");
  const auto told = client.expect<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(end().value("why", ""), told.message);
}

TEST_F(ServerEnds, closingBeforeATlsHandshakeIsNoFailure) {
  startUnderTls();
  { connect(); }
  EXPECT_EQ(end()["reason"], "client");
  EXPECT_EQ(refused("tls"), 0);
}

TEST_F(ServerEnds, closingBeforeABalancerHeaderIsNoFailure) {
  startBehindABalancer();
  { connect(); }
  EXPECT_EQ(end()["reason"], "client");
  EXPECT_EQ(refused("proxy_header"), 0);
}

TEST_F(ServerEnds, aHandshakeThatTakesTooLongIsLoggedAsLateAndNotAsTls) {
  options_.handshake_deadline = 40ms;
  startUnderTls();
  TestClient client = connect();
  EXPECT_EQ(end()["reason"], "handshake");
  EXPECT_FALSE(end().contains("why"));
  EXPECT_EQ(refused("tls"), 0);
}

TEST_F(ServerEnds, aFailedHandshakeIsAcceptedRefusedAndEndedOnceEach) {
  startUnderTls();
  connect().sendText("nonsense");
  expectCountedOnce("tls");
}

TEST_F(ServerEnds, aWrongHeaderIsAcceptedRefusedAndEndedOnceEach) {
  startBehindABalancer();
  connect().sendText("nonsense");
  expectCountedOnce("proxy_header");
}

TEST_F(ServerEnds, aRefusedConnectionIsNotCountedAsAccepted) {
  options_.max_connections = 1;
  start();
  TestClient served = connect();
  served.open("a");
  TestClient refused_client = connect();
  refused_client.expectErrorAndEnd(WireError::kLimit);
  EXPECT_EQ(refused("connections"), 1);
  EXPECT_EQ(metric("lodestream_connections_accepted_total"), 1);
}

TEST_F(ServerEnds, aRevokedTokenIsLoggedAndCountedAsTheReasonOfAnEnd) {
  options_.token_file = folder_.path() / "tokens";
  std::ofstream(options_.token_file) << "one never *\n";
  start();
  TestClient client = connect();
  client.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "one", "test"});
  client.expect<proto::Welcome>(FrameType::kWelcome);
  std::ofstream(options_.token_file) << "two never *\n";
  server_->reload();
  EXPECT_EQ(end()["reason"], "mistake");
  EXPECT_EQ(refused("token"), 1);
  EXPECT_EQ(ended("broken"), 0);
}

TEST_F(ServerEnds, damagedBlobsOfAModelAreCountedFromZero) {
  start();
  EXPECT_EQ(metric("lodestream_model_damaged_blobs_total{model=\"a\"}"), 0);
}

TEST_F(ServerEnds, certificateExpiryIsInTheMetricsAndLoggedOncePast) {
  startUnderTls();
  const double now = static_cast<double>(std::time(nullptr));
  EXPECT_NEAR(metric("lodestream_certificate_expires_seconds"), now + 3600, 120);
  lode::test::writeCertificate(options_.tls_certificate, options_.tls_key, -60);
  server_->reload();
  EXPECT_LT(metric("lodestream_certificate_expires_seconds"), now);
  stop();
  server_.reset();
  EXPECT_NE(lode::test::readBytes(path_).find("the certificate has expired"), std::string::npos);
}

TEST_F(ServerEnds, theExpiryOfAllTokensIsLogged) {
  options_.token_file = folder_.path() / "tokens";
  std::ofstream(options_.token_file) << "one 2020-01-01T00:00:00Z *\ntwo 2999-01-01T00:00:00Z *\n";
  start();
  std::ofstream(options_.token_file) << "one 2020-01-01T00:00:00Z *\n";
  server_->reload();
  stop();
  server_.reset();
  const std::string log = lode::test::readBytes(path_);
  const std::string_view kWarning = "all tokens of the token file have expired";
  const size_t first = log.find(kWarning);
  ASSERT_NE(first, std::string::npos) << log;
  EXPECT_EQ(log.find(kWarning, first + 1), std::string::npos) << "not of the first file";
}

TEST_F(ServerEnds, aTokenForAnUnknownModelIsLogged) {
  options_.token_file = folder_.path() / "tokens";
  std::ofstream(options_.token_file) << "one never a bunny\n";
  start();
  stop();
  server_.reset();
  EXPECT_NE(lode::test::readBytes(path_).find(R"("first":"bunny","count":1)"), std::string::npos)
      << lode::test::readBytes(path_);
}

}  // namespace
}  // namespace lode::serve
