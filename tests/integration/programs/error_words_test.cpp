// Tests of errors without a usable server. The message has one line: what failed and, once, what to do.

#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "programs.h"
#include "tests/support/test_certificate.h"

namespace lode::test {
namespace {

using Strings = std::vector<std::string>;

/// A silent connection that occupies a slot.
class SilentClient {
 public:
  explicit SilentClient(const std::string& server) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(std::stoi(server.substr(server.rfind(':') + 1))));
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~SilentClient() { close(socket_); }
  SilentClient(const SilentClient&) = delete;
  SilentClient& operator=(const SilentClient&) = delete;

 private:
  const int socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
};

class ErrorWords : public testing::Test {
 protected:
  void serve(const Strings& more = {}) { server_.emplace(std::vector<std::filesystem::path>{store_}, more); }
  void serveUnderTls() {
    writeCertificate(folder_ / "a.crt", folder_ / "a.key");
    serve({"--tls-cert", folder_ / "a.crt", "--tls-key", folder_ / "a.key"});
  }
  const std::string& where() const { return server_->address(); }

  static void expectWords(const Strings& arguments, const std::string& words) {
    const Outcome outcome = lodestream(arguments);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.err, "lodestream: " + words + "\n");
  }

  const WorkFolder folder_;
  const std::filesystem::path store_ = makeSmallStore(folder_);
  std::optional<RunningServer> server_;
};

TEST_F(ErrorWords, quoteAFullServer) {
  serve({"--max-connections", "1"});
  const SilentClient first(where());
  const std::string said =
      "the server says: this server is full (1 connection); try again later, or another server";
  expectWords({"list", server_->url()}, where() + ": " + said);
  expectWords({"fetch", server_->url("small"), "--timeout", "0.5"},
              "no answer from " + where() + " within 500 ms: " + said);
  expectWords({"loadtest", server_->url("small"), "--clients", "1", "--seconds", "1"}, where() + ": " + said);
}

TEST_F(ErrorWords, nameTheLastFailedAttemptAfterALostConnection) {
  serve({"--max-rate", "10K"});
  Program fetch("lodestream",
                {"fetch", server_->url("small"), "--cache", folder_ / "cache", "--timeout", "5"});
  waitForFile(folder_ / "cache" / "models", "");  // the client has opened the model
  server_->kill();
  const Outcome outcome = fetch.wait();
  EXPECT_EQ(outcome.err, "lodestream: " + server_->url("small") +
                             " did not converge at key 0 within 5000 ms: cannot connect to " + where() +
                             " (Connection refused): check that lodestreamd serve runs there\n");
}

TEST_F(ErrorWords, pointToListIfTheServerLacksTheModel) {
  serve();
  expectWords(
      {"fetch", server_->url("another")},
      where() + ": the server says: this server has no model 'another'; lodestream list shows what it has");
}

TEST_F(ErrorWords, adviseOnAMissingOutputFolder) {
  const std::string cut = folder_ / "missing" / "cut.ply";
  expectWords(
      {"fetch", store_, "-o", cut},
      "cannot create " + cut + ": No such file or directory; name a folder that is there and can be written");
}

TEST_F(ErrorWords, adviseOnAnUntrustedCertificate) {
  serveUnderTls();
  expectWords({"fetch", "lodes://" + where() + "/small"},
              where() +
                  ": the server's certificate is not trusted: self-signed certificate; use the host name "
                  "of the certificate, and give its authority with --ca-file");
}

TEST_F(ErrorWords, adviseOnAServerWithoutTls) {
  serve();
  expectWords({"fetch", "lodes://" + where() + "/small"},
              where() + ": the TLS handshake failed: wrong version number; use lode:// if it serves no TLS");
}

TEST_F(ErrorWords, nameTheServerThatRequiresAToken) {
  writeBytes(folder_ / "tokens", "right never *\n");
  serve({"--token-file", folder_ / "tokens"});
  const std::string words =
      where() +
      ": the server says: this server requires a token; give a token with --token-file or LODESTREAM_TOKEN";
  expectWords({"list", server_->url()}, words);
  expectWords({"loadtest", server_->url("small"), "--clients", "1", "--seconds", "1"}, words);
}

}  // namespace
}  // namespace lode::test
