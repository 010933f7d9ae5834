#include "client/net/tcp_transport.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/steady_timer.hpp>
#include <asio/write.hpp>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <netdb.h>

#include "common/error.h"
#include "tests/support/own_entries.h"

namespace lode::net {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;

/// A host name whose lookup blocks until release.
class SlowName {
 public:
  static constexpr const char* kHost = "slow.example";

  void lookUp() {
    std::unique_lock lock(mutex_);
    begun_ = true;
    change_.notify_all();
    change_.wait_for(lock, 5s, [this] { return open_; });
    ended_ = true;
    change_.notify_all();
  }
  bool waitUntilBegun() {
    std::unique_lock lock(mutex_);
    return change_.wait_for(lock, 300s, [this] { return begun_; });
  }
  bool ended() {
    const std::lock_guard lock(mutex_);
    return ended_;
  }
  void releaseStorage() {
    std::unique_lock lock(mutex_);
    open_ = true;
    change_.notify_all();
    change_.wait(lock, [this] { return ended_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable change_;
  bool begun_ = false, open_ = false, ended_ = false;
} slow_name;

}  // namespace
}  // namespace lode::net

/// Replaces the system's function, to block for SlowName.
extern "C" int getaddrinfo(const char* node, const char* service, const addrinfo* hints, addrinfo** found) {
  if (std::string_view(node) == lode::net::SlowName::kHost) {
    lode::net::slow_name.lookUp();
    return EAI_NONAME;
  }
  static const auto system = reinterpret_cast<decltype(&getaddrinfo)>(dlsym(RTLD_NEXT, "getaddrinfo"));
  return system(node, service, hints, found);
}

namespace lode::net {
namespace {

/// Counts wake calls, so that a test can wait without polling.
class Bell {
 public:
  void ring() {
    const std::lock_guard lock(mutex_);
    lod_ = true;
    condition_.notify_one();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(condition_.wait_for(lock, 300s, [this] { return lod_; }));
    lod_ = false;
  }

 private:
  std::mutex mutex_;
  std::condition_variable condition_;
  bool lod_ = false;
};

class TcpTransportTest : public testing::Test {
 protected:
  Address address() const { return {"127.0.0.1", acceptor_.local_endpoint().port()}; }
  Route route() const { return {address()}; }

  proto::Bytes receive(TcpTransport& transport, size_t count) {
    proto::Bytes all;
    while (all.size() < count) {
      bell_.wait();
      const proto::Bytes some = transport.takeReceived();
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  }

  std::string failureOf(TcpTransport& transport) {
    while (true) {
      try {
        transport.takeReceived();
      } catch (const Error& error) {
        return error.what();
      }
      bell_.wait();
    }
  }

  /// Returns the number of bytes received before the connection closes; nothing if it stays open.
  std::optional<size_t> receivedUntilTheEnd(tcp::socket& peer) {
    proto::Bytes all(2 * kMaxUnsentBytes);
    std::optional<size_t> received;
    asio::async_read(peer, asio::buffer(all), [&](const asio::error_code& error, size_t count) {
      if (error) received = count;
    });
    io_.run_for(300s);
    if (!received) {
      peer.close();
      io_.restart();
      io_.run();
      return std::nullopt;
    }
    return received;
  }

  asio::io_context io_;
  tcp::acceptor acceptor_{io_, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  std::vector<tcp::socket> peers_;
  Bell bell_;
};

TEST_F(TcpTransportTest, carriesBytesBothWays) {
  TcpTransport transport(route(), [this] { bell_.ring(); });
  transport.send(proto::Bytes(1000, std::byte{1}));
  transport.send(proto::Bytes(500, std::byte{2}));
  tcp::socket peer = acceptor_.accept();
  proto::Bytes got(1500);
  asio::read(peer, asio::buffer(got));
  EXPECT_EQ(got[999], std::byte{1});
  EXPECT_EQ(got[1000], std::byte{2});
  asio::write(peer, asio::buffer(got));
  EXPECT_EQ(receive(transport, got.size()), got);
}

TEST_F(TcpTransportTest, appliesBackPressureWithoutLoss) {
  TcpTransport transport(route(), [this] { bell_.ring(); });
  tcp::socket peer = acceptor_.accept();
  constexpr size_t kMany = 3 * kMaxReceivedBytes;
  std::thread sender([&] {
    proto::Bytes many(kMany);
    for (size_t i = 0; i < kMany; ++i) many[i] = static_cast<std::byte>(i / 1000);
    asio::write(peer, asio::buffer(many));
  });
  size_t taken = 0;
  while (taken < kMany) {
    bell_.wait();
    const proto::Bytes some = transport.takeReceived();
    EXPECT_LT(some.size(), kMaxReceivedBytes + (1u << 20));
    for (const std::byte byte : some) ASSERT_EQ(byte, static_cast<std::byte>(taken++ / 1000));
  }
  sender.join();
}

TEST_F(TcpTransportTest, givesTheLastBytesBeforeItTellsOfTheEnd) {
  TcpTransport transport(route(), [this] { bell_.ring(); });
  {
    tcp::socket peer = acceptor_.accept();
    asio::write(peer, asio::buffer("last", 4));
  }
  EXPECT_EQ(receive(transport, 4).size(), 4u);
  EXPECT_NE(failureOf(transport).find("closed the connection"), std::string::npos);
}

TEST_F(TcpTransportTest, endsAtOnceDuringANameLookup) {
  {
    TcpTransport transport(Route{{SlowName::kHost, 1}}, [] {});
    ASSERT_TRUE(slow_name.waitUntilBegun());
  }
  EXPECT_FALSE(slow_name.ended());
  slow_name.releaseStorage();
}

TEST_F(TcpTransportTest, reportsAnUnknownHost) {
  TcpTransport transport(Route{{"host.invalid", 1}}, [this] { bell_.ring(); });
  EXPECT_NE(failureOf(transport).find("cannot find the host of host.invalid:1"), std::string::npos);
}

TEST_F(TcpTransportTest, namesTheAddressAndTheRemedyWhenNobodyListens) {
  const Address nobody = address();
  acceptor_.close();
  TcpTransport transport(Route{nobody}, [this] { bell_.ring(); });
  const std::string failure = failureOf(transport);
  EXPECT_NE(failure.find(toString(nobody)), std::string::npos) << failure;
  EXPECT_NE(failure.find("lodestreamd serve"), std::string::npos) << failure;
}

TEST_F(TcpTransportTest, waitsNoLongerForTheFirstWordThanForAConnection) {
  Route impatient = route();
  impatient.connect_timeout = 50ms;
  TcpTransport transport(impatient, [&] { bell_.ring(); });
  const tcp::socket silent = acceptor_.accept();
  const std::string failure = failureOf(transport);
  EXPECT_NE(failure.find("no answer from " + toString(address()) + " within 50 ms"), std::string::npos)
      << failure;
}

TEST_F(TcpTransportTest, staysOpenIfTheFirstByteArrivesInTime) {
  Route impatient = route();
  impatient.connect_timeout = 1s;
  TcpTransport transport(impatient, [&] { bell_.ring(); });
  tcp::socket peer = acceptor_.accept();
  asio::write(peer, asio::buffer("1", 1));
  receive(transport, 1);
  asio::steady_timer longer(io_, 1200ms);
  longer.wait();
  asio::write(peer, asio::buffer("2", 1));
  EXPECT_EQ(receive(transport, 1).size(), 1u);
}

TEST_F(TcpTransportTest, refusesToQueueMoreThanTheLimit) {
  TcpTransport transport(route(), [] {});
  tcp::socket peer = acceptor_.accept();
  const auto sendForever = [&] {
    for (int i = 0; i < 1000; ++i) transport.send(proto::Bytes(4u << 20));
  };
  EXPECT_THROW(sendForever(), Error);
}

TEST_F(TcpTransportTest, leavesNoThreadOrDescriptorIfItEndsWhileConnecting) {
  std::thread([] {}).join();  // the first thread starts one of the thread sanitizer too
  const size_t threads_before = test::ownEntries("task"), descriptors_before = test::ownEntries("fd");
  for (int i = 0; i < 30; ++i) TcpTransport(route(), [] {});
  EXPECT_LE(test::ownEntriesOnceDownTo(threads_before, "task"), threads_before);
  EXPECT_LE(test::ownEntriesOnceDownTo(descriptors_before, "fd"), descriptors_before);
}

TEST_F(TcpTransportTest, closesTheConnectionIfItEndsWhileSending) {
  acceptor_.set_option(asio::socket_base::receive_buffer_size(1 << 16));
  std::optional<TcpTransport> transport(std::in_place, route(), [] {});
  transport->send(proto::Bytes(kMaxUnsentBytes));  // more than the socket buffers hold
  tcp::socket peer = acceptor_.accept();
  peer.wait(tcp::socket::wait_read);
  transport.reset();
  const std::optional<size_t> got = receivedUntilTheEnd(peer);
  ASSERT_TRUE(got);
  EXPECT_LT(*got, kMaxUnsentBytes);
}

TEST_F(TcpTransportTest, closesTheConnectionIfItEndsWhileReceiving) {
  std::optional<TcpTransport> transport(std::in_place, route(), [this] { bell_.ring(); });
  tcp::socket peer = acceptor_.accept();
  asio::write(peer, asio::buffer(proto::Bytes(kMaxReceivedBytes)));
  bell_.wait();
  transport.reset();
  EXPECT_EQ(receivedUntilTheEnd(peer), 0u);
}

TEST_F(TcpTransportTest, sharesACallersLoopWithManyOthers) {
  asio::io_context loop;
  size_t wakes = 0;
  std::vector<std::unique_ptr<TcpTransport>> transports;
  for (int i = 0; i < 20; ++i) {
    transports.push_back(std::make_unique<TcpTransport>(loop, route(), [&wakes] { ++wakes; }));
    transports.back()->send(proto::Bytes(100, static_cast<std::byte>(i)));
  }
  std::thread peer([this] {
    for (int i = 0; i < 20; ++i) {
      tcp::socket socket = acceptor_.accept();
      proto::Bytes got(100);
      asio::read(socket, asio::buffer(got));
      asio::write(socket, asio::buffer(got));
      peers_.push_back(std::move(socket));
    }
  });
  while (wakes < transports.size() && loop.run_one_for(300s) > 0) continue;
  peer.join();
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(transports[static_cast<size_t>(i)]->takeReceived(),
              proto::Bytes(100, static_cast<std::byte>(i)));
}

TEST_F(TcpTransportTest, wakesNobodyAfterItsDestruction) {
  asio::io_context loop;
  bool woken = false;
  {
    TcpTransport transport(loop, route(), [&woken] { woken = true; });
    transport.send(proto::Bytes(1000));
    loop.poll();
  }
  loop.restart();
  loop.run();  // returns, since the transport has left nothing on the loop
  EXPECT_FALSE(woken);
}

}  // namespace
}  // namespace lode::net
