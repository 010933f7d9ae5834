// Tests of access: tokens, TLS, the balancer's header, reloads.

#include <fstream>
#include <functional>
#include <sstream>

#include <sys/stat.h>

#include "common/error.h"
#include "server/serve/net/refusals.h"
#include "server/serve/net/wrong_tokens.h"
#include "tests/support/test_certificate.h"
#include "tests/unit/serve/server_fixture.h"
#include "tests/unit/serve/tls_client.h"

namespace lode::serve {
namespace {

using namespace test;

class ServerAccess : public ServerTest {
 protected:
  void writeTokens(const std::string& text) {
    options_.token_file = folder_.path() / "tokens";
    std::ofstream(options_.token_file) << text;
  }
  void writePair(const std::string& name) {
    options_.tls_certificate = folder_.path() / (name + ".crt");
    options_.tls_key = folder_.path() / (name + ".key");
    lode::test::writeCertificate(options_.tls_certificate, options_.tls_key);
  }
  /// Sends Hello with a token. @return the type of the answer.
  FrameType greet(TestClient& client, const std::string& token) {
    client.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, token, "test"});
    const auto answer = client.receive();
    return answer ? static_cast<FrameType>(answer->header.type) : FrameType{};
  }
  std::vector<std::string> list(TestClient& client) {
    client.send(proto::List{});
    std::vector<std::string> names;
    for (const ModelSummary& model : client.expect<proto::Models>(FrameType::kModels).models)
      names.push_back(model.name);
    return names;
  }
  /// Starts a server, calls act(), reloads the server's files and ends the server. @return the server's log.
  std::string logOfReloadAfter(const std::function<void()>& act) {
    const std::filesystem::path log = folder_.path() / "log.txt";
    const int descriptor = ::open(log.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    options_.log.descriptor = descriptor;
    start();
    act();
    server_->reload();
    stop();
    server_.reset();
    ::close(descriptor);
    std::ostringstream said;
    said << std::ifstream(log).rdbuf();
    return said.str();
  }
};

TEST_F(ServerAccess, aConnectionWithoutAKnownTokenIsRefused) {
  writeTokens("right never *\n");
  start();
  for (const char* token : {"", "wrong", "right "}) {
    TestClient client = connect();
    client.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, token, "test"});
    client.expectErrorAndEnd(WireError::kUnauthorized);
  }
  TestClient client = connect();
  EXPECT_EQ(greet(client, "right"), FrameType::kWelcome);
}

TEST_F(ServerAccess, wrongTokensAreAnsweredEverLaterAndARightOneAtOnce) {
  writeTokens("right never *\n");
  options_.wrong_token_delay = 20ms;
  start();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 3; ++i) {
    TestClient client = connect();
    client.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "wrong", "test"});
    client.expectErrorAndEnd(WireError::kUnauthorized);
  }
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 20ms + 40ms + 80ms);
  TestClient client = connect();
  EXPECT_EQ(greet(client, "right"), FrameType::kWelcome);
}

TEST_F(ServerAccess, aDelayedAnswerHoldsNeitherAConnectionsPlaceNorItsMemory) {
  writeTokens("right never *\n");
  options_.wrong_token_delay = WrongTokens::kLongestDelay;
  options_.max_connections = 1;
  start();
  TestClient waiting = connect();
  waiting.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "wrong", "test"});
  while (server_->memoryHeld() > 0) std::this_thread::yield();
  FrameType answer{};
  do {  // the server may not have read the wrong token yet
    TestClient client = connect();
    answer = greet(client, "right");
  } while (answer != FrameType::kWelcome);
  EXPECT_FALSE(waiting.hasReceived());
}

TEST_F(ServerAccess, anAddressWithManyDelayedWrongTokensIsBlocked) {
  writeTokens("right never *\n");
  options_.wrong_token_delay = WrongTokens::kLongestDelay;
  start();
  std::vector<std::unique_ptr<TestClient>> waiting;
  for (uint32_t i = 0; i < WrongTokens::kMostWaitingPerAddress; ++i) {
    waiting.push_back(std::make_unique<TestClient>(server_->port()));
    waiting.back()->send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "wrong", "test"});
  }
  std::optional<Received> answer;
  do {  // the server may not have read all wrong tokens yet
    TestClient client = connect();
    client.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "right", "test"});
    answer = client.receive();
  } while (answer && answer->is(FrameType::kWelcome));
  ASSERT_TRUE(answer && answer->is(FrameType::kError));
  EXPECT_EQ(proto::decode<proto::ErrorMessage>(answer->body).code, WireError::kLimit);
}

TEST_F(ServerAccess, anExpiredTokenIsRefused) {
  writeTokens("old 2020-01-31T12:00:00Z *\n");
  start();
  TestClient client = connect();
  client.send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "old", "test"});
  client.expectErrorAndEnd(WireError::kUnauthorized);
}

TEST_F(ServerAccess, aTokenListsAndOpensOnlyItsModels) {
  writeTokens("some never b\n");
  start();
  TestClient client = connect();
  ASSERT_EQ(greet(client, "some"), FrameType::kWelcome);
  EXPECT_EQ(list(client), std::vector<std::string>{"b"});
  client.send(proto::Open{"a", {}});
  EXPECT_EQ(client.expect<proto::ErrorMessage>(FrameType::kError).code, WireError::kNoSuchModel);
  client.send(proto::Open{"b", {}});
  client.expect<proto::Opened>(FrameType::kOpened);
}

TEST_F(ServerAccess, aRemovedTokenEndsOnlyItsSessionsOnAReload) {
  writeTokens("one never *\ntwo never *\n");
  start();
  TestClient first = connect(), second = connect();
  ASSERT_EQ(greet(first, "one"), FrameType::kWelcome);
  ASSERT_EQ(greet(second, "two"), FrameType::kWelcome);
  writeTokens("two never *\n");
  server_->reload();
  first.expectErrorAndEnd(WireError::kUnauthorized);
  EXPECT_EQ(list(second), (std::vector<std::string>{"a", "b"}));
}

TEST_F(ServerAccess, anInvalidTokenFileKeepsTheOldTokensOnAReload) {
  writeTokens("one never *\n");
  start();
  writeTokens("one sometimes *\n");
  server_->reload();
  TestClient client = connect();
  EXPECT_EQ(greet(client, "one"), FrameType::kWelcome);
}

TEST_F(ServerAccess, aMissingFolderOfStoresKeepsTheOldModelsOnAReload) {
  const std::filesystem::path models = folder_.path() / "models";
  std::filesystem::create_directory(models);
  writeSmallStore(models / "c.lode", 3);
  options_.stores = {store_, models};
  start();
  std::filesystem::remove_all(models);
  server_->reload();
  TestClient client = connect();
  ASSERT_EQ(greet(client, ""), FrameType::kWelcome);
  EXPECT_EQ(list(client), (std::vector<std::string>{"a", "c"}));
}

TEST_F(ServerAccess, aServerStartsAndAnswersWhileAReloadWaitsForTheDisk) {
  writeTokens("one never *\n");
  server_.emplace(options_);
  std::filesystem::remove(options_.token_file);
  ASSERT_EQ(::mkfifo(options_.token_file.c_str(), 0600), 0);  // reading a FIFO blocks, as on a slow disk
  std::jthread reload([this] { server_->reload(); });
  std::ofstream disk(options_.token_file);
  thread_ = std::thread([this] { server_->run(); });
  TestClient client = connect();
  EXPECT_EQ(greet(client, "one"), FrameType::kWelcome);
}

TEST_F(ServerAccess, aReloadThatFailsIsLoggedWithoutAFolder) {
  const std::filesystem::path hidden = folder_.path() / "not for (others) to 'know'";
  std::filesystem::create_directories(hidden / "models");
  writeSmallStore(hidden / "models" / "a.lode", 1);
  options_.stores = {hidden / "models"};
  options_.tls_certificate = hidden / "chain.pem";
  options_.tls_key = hidden / "key.pem";
  lode::test::writeCertificate(options_.tls_certificate, options_.tls_key);
  writeTokens("one never *\n");
  const std::string said = logOfReloadAfter([&] {
    writeTokens("one sometimes *\n");
    std::filesystem::remove_all(hidden);
  });
  for (const char* what : {"stores", "tokens", "the certificate"})
    EXPECT_NE(said.find(std::string(what) + " could not be reloaded"), std::string::npos) << said;
  for (const char* folder : {"tmp", "not for", "others", "know"})
    EXPECT_EQ(said.find(folder), std::string::npos) << said;
}

TEST_F(ServerAccess, aReloadThatSkipsAStoreIsLoggedAsPartial) {
  const std::string said = logOfReloadAfter([&] { std::ofstream(folder_.path() / "junk.lode") << "junk\n"; });
  EXPECT_NE(said.find("reloaded partly"), std::string::npos) << said;
}

TEST_F(ServerAccess, aReloadOffersNewModelsAndAnnouncesReplacedOnes) {
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  writeSmallStore(folder_.path() / "new.tmp", 77);
  std::filesystem::rename(folder_.path() / "new.tmp", store_);
  writeSmallStore(folder_.path() / "c.lode", 3);
  std::filesystem::remove(folder_.path() / "b.lode");
  server_->reload();
  EXPECT_EQ(client.expect<proto::ModelReplaced>(FrameType::kModelReplaced).handle, opened.handle);
  EXPECT_EQ(list(client), (std::vector<std::string>{"a", "c"}));
  const uint32_t blob = 5;
  client.send(proto::Requests{opened.handle, {{RequestAction::kAdd, RequestClass::kVisible, 1, blob, 5}}});
  const auto old = client.blobs(1);
  ASSERT_EQ(old.size(), 1u);
  EXPECT_NE(old[0].second, reader().readBlob(blob)) << "the open handle keeps what it opened";
  TestClient later = connect();
  EXPECT_NE(later.open("a").summary.build_id, opened.summary.build_id);
}

TEST_F(ServerAccess, aBalancersHeaderGivesTheAddressOfTheClient) {
  options_.proxy_protocol = true;
  options_.max_connections_per_address = 1;
  start();
  TestClient first = connect();
  first.sendText("PROXY TCP4 192.0.2.1 192.0.2.9 5000 7400\r\n");
  first.open("a");
  TestClient same = connect();
  same.sendText("PROXY TCP4 192.0.2.1 192.0.2.9 5001 7400\r\n");
  same.expectErrorAndEnd(WireError::kLimit);
  TestClient other = connect();
  for (const char byte : std::string("PROXY TCP4 192.0.2.2 192.0.2.9 5001 7400\r\n"))
    other.sendText(std::string_view(&byte, 1));
  other.open("a");
}

TEST_F(ServerAccess, aConnectionWithoutTheBalancersHeaderIsClosed) {
  options_.proxy_protocol = true;
  start();
  TestClient client = connect();
  client.send(proto::Hello{});
  EXPECT_FALSE(client.receive());
}

TEST_F(ServerAccess, aSessionIsTheSameUnderTls) {
  writePair("first");
  start();
  TlsClient client(server_->port());
  ASSERT_TRUE(client.connected());
  client.send(proto::Hello{});
  EXPECT_EQ(client.receive(), FrameType::kWelcome);
  client.send(proto::Open{"a", {}});
  EXPECT_EQ(client.receive(), FrameType::kOpened);
  EXPECT_EQ(client.receive(), FrameType::kBlob);
}

TEST_F(ServerAccess, aTlsVersionBelow13IsRefused) {
  writePair("first");
  start();
  EXPECT_FALSE(TlsClient(server_->port(), TLS1_2_VERSION).connected());
}

TEST_F(ServerAccess, aPlainClientOfATlsServerIsDisconnectedAndOthersAreServed) {
  writePair("first");
  start();
  TestClient plain = connect();
  plain.send(proto::Hello{});
  while (plain.receive()) {
  }
  TlsClient client(server_->port());
  EXPECT_TRUE(client.connected());
}

TEST_F(ServerAccess, aRefusedClientGetsAnErrorUnderTlsToo) {
  options_.max_connections = 1;
  writePair("first");
  start();
  TlsClient served(server_->port());
  ASSERT_TRUE(served.connected());
  for (int i = 0; i < 5; ++i) {
    TlsClient refused(server_->port());
    ASSERT_TRUE(refused.connected());
    refused.send(proto::Hello{});
    EXPECT_EQ(refused.receive(), FrameType::kError);
    EXPECT_EQ(refused.receive(), FrameType{});
  }
  served.send(proto::Hello{});
  EXPECT_EQ(served.receive(), FrameType::kWelcome);
}

TEST_F(ServerAccess, refusedClientsWithoutATlsHandshakeAreClosed) {
  options_.max_connections = 1;
  writePair("first");
  start();
  TlsClient served(server_->port());
  ASSERT_TRUE(served.connected());
  std::vector<std::unique_ptr<TestClient>> silent;
  for (size_t i = 0; i < 2 * Refusals::kMostHandshakes; ++i)
    silent.push_back(std::make_unique<TestClient>(server_->port()));
  for (auto& client : silent) EXPECT_FALSE(client->receive());
  TlsClient refused(server_->port());
  refused.send(proto::Hello{});
  EXPECT_EQ(refused.receive(), FrameType::kError);
}

TEST_F(ServerAccess, aClientWithoutATlsHandshakeIsDisconnected) {
  options_.handshake_deadline = 40ms;
  writePair("first");
  start();
  TestClient silent = connect();
  EXPECT_FALSE(silent.receive());
}

TEST_F(ServerAccess, aNewCertificateIsUsedAndOldSessionsContinue) {
  writePair("first");
  start();
  TlsClient before(server_->port());
  ASSERT_TRUE(before.connected());
  lode::test::writeCertificate(options_.tls_certificate, options_.tls_key);
  server_->reload();
  TlsClient after(server_->port());
  EXPECT_TRUE(after.connected());
  before.send(proto::Hello{});
  EXPECT_EQ(before.receive(), FrameType::kWelcome);
  std::ofstream(options_.tls_key) << "no key";
  server_->reload();
  EXPECT_TRUE(TlsClient(server_->port()).connected()) << "what is wrong leaves what there was";
}

TEST_F(ServerAccess, listeningBeyondLoopbackNeedsTokensOrPublicAndTlsOrInsecure) {
  options_.listen = "0.0.0.0:0";
  const auto starts = [&](bool tokens, bool tls, bool public_ok, bool insecure) {
    ServeOptions options = options_;
    options.public_ok = public_ok;
    options.insecure = insecure;
    if (!tokens) options.token_file.clear();
    if (!tls) options.tls_certificate = options.tls_key = "";
    try {
      Server server(options);
      return true;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage) << error.what();
      return false;
    }
  };
  writeTokens("one never *\n");
  writePair("first");
  for (int given = 0; given < 16; ++given) {
    const bool tokens = given & 1, tls = given & 2, public_ok = given & 4, insecure = given & 8;
    EXPECT_EQ(starts(tokens, tls, public_ok, insecure), (tokens || public_ok) && (tls || insecure)) << given;
  }
}

TEST_F(ServerAccess, metricsBeyondLoopbackNeedPublic) {
  writeTokens("one never *\n");
  for (const char* const metrics : {"0.0.0.0:0", "[::]:0"}) {
    options_.metrics = metrics;
    options_.public_ok = false;
    EXPECT_THROW(Server{options_}, Error) << metrics;
    options_.public_ok = true;
    EXPECT_NO_THROW(Server{options_}) << metrics;
  }
  options_.public_ok = false;
  options_.metrics = "127.0.0.1:0";
  EXPECT_NO_THROW(Server{options_});
}

TEST_F(ServerAccess, aKeyThatOthersCanReadOrWriteIsRefusedUnlessInsecure) {
  writePair("first");
  for (const mode_t mode : {0644u, 0640u, 0602u}) {
    std::filesystem::permissions(options_.tls_key, std::filesystem::perms(mode));
    options_.insecure = false;
    EXPECT_THROW(Server{options_}, Error) << mode;
    options_.insecure = true;
    EXPECT_NO_THROW(Server{options_}) << mode;
  }
}

TEST_F(ServerAccess, aKeyOfAnotherCertificateIsRefused) {
  writePair("first");
  lode::test::writeCertificate(folder_.path() / "other.crt", options_.tls_key);
  EXPECT_THROW(Server{options_}, Error);
}

}  // namespace
}  // namespace lode::serve
