// TLS connections: trusted certificates, and errors for untrusted ones.

#include <condition_variable>
#include <fstream>
#include <mutex>
#include <optional>
#include <thread>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/ssl/context.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>
#include <gtest/gtest.h>

#include "client/net/tcp_transport.h"
#include "common/error.h"
#include "tests/support/test_certificate.h"
#include "tests/support/work_folder.h"

namespace lode::net {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;

/// An echo server for one connection, with a certificate for "localhost".
class EchoUnderTls : public testing::Test {
 protected:
  EchoUnderTls() {
    test::writeCertificate(folder_ / "a.crt", folder_ / "a.key");
    test::writeCertificate(folder_ / "other.crt", folder_ / "other.key");
    context_.use_certificate_chain_file((folder_ / "a.crt").string());
    context_.use_private_key_file((folder_ / "a.key").string(), asio::ssl::context::pem);
    thread_ = std::thread([this] { echo(); });
  }
  ~EchoUnderTls() override {
    asio::error_code ignored;
    acceptor_.close(ignored);
    tcp::socket(io_).connect(tcp::endpoint(asio::ip::address_v4::loopback(), port_), ignored);
    thread_.join();
  }

  Route route(const std::string& host, const char* authorities) const {
    return {{host, port_}, 10s, trustAuthorities(folder_ / authorities)};
  }

  /// Returns the echo, or the error's message. Stores the error's remedy.
  std::string answerTo(const std::string& text, const Route& route) {
    TcpTransport transport(route, [this] {
      const std::lock_guard lock(mutex_);
      lod_ = true;
      bell_.notify_one();
    });
    proto::Bytes bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    transport.send(bytes);
    std::string answer;
    while (answer.size() < text.size()) {
      {
        std::unique_lock lock(mutex_);
        if (!bell_.wait_for(lock, 300s, [this] { return lod_; })) return "nothing";
        lod_ = false;
      }
      try {
        for (const std::byte byte : transport.takeReceived()) answer += static_cast<char>(byte);
      } catch (const Error& error) {
        remedy_ = error.remedy();
        return error.what();
      }
    }
    return answer;
  }

  void echo() {
    asio::error_code error;
    tcp::socket socket(io_);
    acceptor_.accept(socket, error);
    if (error) return;
    asio::ssl::stream<tcp::socket> stream(std::move(socket), context_);
    stream.handshake(asio::ssl::stream_base::server, error);
    std::array<char, 64> buffer{};
    while (!error) {
      const size_t count = stream.read_some(asio::buffer(buffer), error);
      if (!error) asio::write(stream, asio::buffer(buffer, count), error);
    }
  }

  const test::WorkFolder folder_;
  asio::io_context io_;
  asio::ssl::context context_{asio::ssl::context::tls_server};
  tcp::acceptor acceptor_{io_, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  const uint16_t port_ = acceptor_.local_endpoint().port();
  std::mutex mutex_;
  std::condition_variable bell_;
  bool lod_ = false;
  Remedy remedy_ = Remedy::kNone;
  std::thread thread_;
};

TEST_F(EchoUnderTls, carriesBytesOfATrustedServer) {
  EXPECT_EQ(answerTo("some words", route("localhost", "a.crt")), "some words");
}

TEST_F(EchoUnderTls, isRefusedIfItsCertificateIsNotTrusted) {
  const std::string failure = answerTo("secret", route("localhost", "other.crt"));
  EXPECT_NE(failure.find("certificate is not trusted"), std::string::npos) << failure;
  EXPECT_EQ(remedy_, Remedy::kCertificate);
}

TEST_F(EchoUnderTls, isRefusedIfItsCertificateIsForAnotherHost) {
  const std::string failure = answerTo("secret", route("127.0.0.1", "a.crt"));
  EXPECT_NE(failure.find("mismatch"), std::string::npos) << failure;
  EXPECT_EQ(remedy_, Remedy::kCertificate);
}

TEST(Authorities, areReadFromAnExistingFileOfCertificates) {
  const test::WorkFolder folder;
  std::ofstream(folder / "text") << "no certificate";
  for (const char* const name : {"text", "none"}) {
    try {
      trustAuthorities(folder / name);
      ADD_FAILURE() << "trusted: " << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.remedy(), Remedy::kAuthorities) << error.what();
    }
  }
  EXPECT_TRUE(trustAuthorities({}));
}

TEST(TlsTransport, saysThatAServerWithoutTlsHasNone) {
  asio::io_context io;
  tcp::acceptor acceptor(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  std::mutex mutex;
  std::condition_variable bell;
  bool lod = false;
  TcpTransport transport({{"127.0.0.1", acceptor.local_endpoint().port()}, 10s, trustAuthorities({})}, [&] {
    const std::lock_guard lock(mutex);
    lod = true;
    bell.notify_one();
  });
  tcp::socket peer = acceptor.accept();
  asio::write(peer, asio::buffer("220 no TLS here\r\n", 17));
  std::unique_lock lock(mutex);
  ASSERT_TRUE(bell.wait_for(lock, 300s, [&] { return lod; }));
  lock.unlock();
  try {
    transport.takeReceived();
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("use lode:// if it serves no TLS"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace lode::net
