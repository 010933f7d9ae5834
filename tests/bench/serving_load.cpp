// Loads a server to its limit: serving_load PORT MODEL FIRST LAST CONNECTIONS IN_FLIGHT SECONDS [tls]. Each
// connection keeps IN_FLIGHT requests open for random blobs from FIRST to LAST; with "16,256" the first
// connection keeps 256 and the others 16. The program reads headers and drops the other bytes, so that one
// client core does not limit one server core. Time starts when all connections have the model open. Prints
// blobs, bytes, bytes of each connection, seconds, and percentiles of a request's time, which are exact if
// IN_FLIGHT is 1.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/error.h"
#include "proto/frame.h"
#include "proto/messages.h"

namespace {

using namespace lode;
using Clock = std::chrono::steady_clock;

constexpr uint64_t kEndlessWindow = uint64_t{1} << 60;

struct Counter {
  uint64_t blobs = 0, bytes = 0;
  std::vector<double> times_ms;  ///< time from a Requests frame to the last byte of each requested blob
};

class Client {
 public:
  /// @param tls  null for a plain connection.
  Client(uint16_t port, const std::string& model, uint32_t first, uint32_t last, uint32_t in_flight,
         uint32_t seed, SSL_CTX* tls)
      : socket_(socket(AF_INET, SOCK_STREAM, 0)), any_(first, last), in_flight_(in_flight), random_(seed) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
      throw Error(ErrorCode::kNetwork, "cannot connect to port " + std::to_string(port));
    if (tls != nullptr) shakeHands(tls);
    send(proto::encode(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "", "serving_load"},
                       1));
    send(proto::encode(proto::Open{model, {}}, 2));
    send(proto::encode(proto::Credit{kEndlessWindow}, 0));
  }
  ~Client() {
    SSL_free(tls_);
    close(socket_);
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  int descriptor() const noexcept { return socket_; }
  const Counter& counts() const noexcept { return counts_; }

  /// @param room  read buffer, shared by all clients.
  void read(std::span<std::byte> room) {
    for (int records = tls_ != nullptr ? kRecords : 1; records > 0; --records) {
      const ssize_t got = receive(room);
      if (got == 0) throw Error(ErrorCode::kNetwork, "the server closed a connection");
      if (got < 0) break;
      take(room.first(static_cast<size_t>(got)));
    }
    if (requests_ && open_ + std::min(kRefill, in_flight_) <= in_flight_) request();
  }
  bool opened() const noexcept { return opened_; }
  /// Starts to send requests. Call it when the model is open.
  void begin() {
    requests_ = true;
    request();
  }

 private:
  static constexpr uint32_t kRefill = 8;  ///< requests per frame
  static constexpr int kRecords = 16;     ///< TLS records per read
  static constexpr size_t kHeadBytes = proto::kFrameHeaderBytes + proto::kBlobChunkHeaderBytes;

  void shakeHands(SSL_CTX* tls) {
    tls_ = SSL_new(tls);
    SSL_set_fd(tls_, socket_);
    if (SSL_connect(tls_) != 1) throw Error(ErrorCode::kNetwork, "the TLS handshake failed");
    fcntl(socket_, F_SETFL, O_NONBLOCK);
  }
  /// Reads like recv(): -1 if nothing is available.
  ssize_t receive(std::span<std::byte> room) {
    if (tls_ == nullptr) return recv(socket_, room.data(), room.size(), MSG_DONTWAIT);
    size_t got = 0;
    if (SSL_read_ex(tls_, room.data(), room.size(), &got) == 1) return static_cast<ssize_t>(got);
    return SSL_get_error(tls_, 0) == SSL_ERROR_WANT_READ ? -1 : 0;
  }
  void sendUnderTls(const proto::Bytes& frame) {
    size_t sent = 0;
    while (SSL_write_ex(tls_, frame.data(), frame.size(), &sent) != 1) {
      if (SSL_get_error(tls_, 0) != SSL_ERROR_WANT_WRITE)
        throw Error(ErrorCode::kNetwork, "a connection broke");
      pollfd waiting{socket_, POLLOUT, 0};
      poll(&waiting, 1, -1);
    }
  }
  void send(const proto::Bytes& frame) {
    if (tls_ != nullptr) return sendUnderTls(frame);
    if (::send(socket_, frame.data(), frame.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(frame.size()))
      throw Error(ErrorCode::kNetwork, "a connection broke");
  }
  void request() {
    proto::Requests requests{1, {}};
    asked_ = Clock::now();
    for (; open_ < in_flight_; ++open_)
      requests.changes.push_back(
          {proto::RequestAction::kAdd, proto::RequestClass::kVisible, ++last_request_, any_(random_), 1});
    send(proto::encode(requests, 3));
  }
  /// Takes received bytes, which may end within a frame. Joins the parts of headers and skips bodies.
  void take(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const size_t skipped = std::min(skip_, bytes.size());
      skip_ -= skipped;
      bytes = bytes.subspan(skipped);
      if (bytes.empty()) return;
      while (head_used_ < proto::kFrameHeaderBytes + wanted_fields_ && !bytes.empty()) {
        head_[head_used_++] = bytes.front();
        bytes = bytes.subspan(1);
        if (head_used_ == proto::kFrameHeaderBytes) readHeader();
      }
      if (head_used_ < proto::kFrameHeaderBytes + wanted_fields_) return;
      if (wanted_fields_ > 0) readChunk();
      skip_ = body_bytes_ - wanted_fields_;
      head_used_ = wanted_fields_ = 0;
    }
  }
  void readHeader() {
    const auto header = proto::decodeFrameHeader(std::span(head_).first<proto::kFrameHeaderBytes>());
    body_bytes_ = header.body_bytes;
    const auto type = static_cast<proto::FrameType>(header.type);
    if (type == proto::FrameType::kError) throw Error(ErrorCode::kNetwork, "the server sent an Error");
    opened_ = opened_ || type == proto::FrameType::kOpened;
    wanted_fields_ = type == proto::FrameType::kBlob ? proto::kBlobChunkHeaderBytes : 0;
  }
  void readChunk() {
    const auto u32 = [this](size_t at) {
      uint32_t value = 0;
      for (size_t i = 4; i-- > 0;)
        value = value << 8 | std::to_integer<uint32_t>(head_[proto::kFrameHeaderBytes + at + i]);
      return value;
    };
    const auto bytes = static_cast<uint32_t>(body_bytes_ - proto::kBlobChunkHeaderBytes);
    counts_.bytes += bytes;
    if (u32(8) + bytes < u32(4) || u32(0) == 0) return;
    ++counts_.blobs;
    counts_.times_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - asked_).count());
    --open_;
  }

  int socket_;
  SSL* tls_ = nullptr;
  std::uniform_int_distribution<uint32_t> any_;
  uint32_t in_flight_, open_ = 0, last_request_ = 0;
  std::mt19937 random_;
  std::array<std::byte, kHeadBytes> head_;
  size_t head_used_ = 0, wanted_fields_ = 0, body_bytes_ = 0, skip_ = 0;
  bool opened_ = false, requests_ = false;
  Clock::time_point asked_;
  Counter counts_;
};

double percentile(const std::vector<double>& sorted_ms, double part) {
  return sorted_ms.empty() ? 0
                           : sorted_ms[static_cast<size_t>(part * static_cast<double>(sorted_ms.size() - 1))];
}

void print(std::span<const std::unique_ptr<Client>> clients, double seconds) {
  Counter all;
  std::string each;
  for (const auto& client : clients) {
    all.blobs += client->counts().blobs;
    all.bytes += client->counts().bytes;
    all.times_ms.insert(all.times_ms.end(), client->counts().times_ms.begin(),
                        client->counts().times_ms.end());
    each += (each.empty() ? "" : ", ") + std::to_string(client->counts().bytes);
  }
  std::ranges::sort(all.times_ms);
  std::printf(
      "{\"blobs\": %llu, \"bytes\": %llu, \"each\": [%s], \"seconds\": %.3f, \"p50_ms\": %.3f, \"p99_ms\": "
      "%.3f}\n",
      static_cast<unsigned long long>(all.blobs), static_cast<unsigned long long>(all.bytes), each.c_str(),
      seconds, percentile(all.times_ms, 0.5), percentile(all.times_ms, 0.99));
}

void readWhatHasCome(int poll, std::span<std::byte> room) {
  std::array<epoll_event, 256> events;
  const int count = epoll_wait(poll, events.data(), static_cast<int>(events.size()), 100);
  for (int i = 0; i < count; ++i) static_cast<Client*>(events[static_cast<size_t>(i)].data.ptr)->read(room);
}

void run(std::span<char*> arguments) {
  const auto number = [&](size_t i) {
    return static_cast<uint32_t>(std::strtoul(arguments[i], nullptr, 10));
  };
  const std::string in_flight = arguments[5];
  const size_t comma = in_flight.find(',');
  const uint32_t of_first =
      comma == std::string::npos ? number(5) : static_cast<uint32_t>(std::stoul(in_flight.substr(comma + 1)));
  std::vector<std::unique_ptr<Client>> clients;
  const bool under_tls = arguments.size() > 7;
  SSL_CTX* const tls = under_tls ? SSL_CTX_new(TLS_client_method()) : nullptr;
  const int poll = epoll_create1(0);
  for (uint32_t i = 0; i < number(4); ++i) {
    clients.push_back(std::make_unique<Client>(static_cast<uint16_t>(number(0)), arguments[1], number(2),
                                               number(3), i == 0 ? of_first : number(5), i + 1, tls));
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = clients.back().get();
    epoll_ctl(poll, EPOLL_CTL_ADD, clients.back()->descriptor(), &event);
  }
  std::vector<std::byte> room(256u << 10);
  while (!std::ranges::all_of(clients, &Client::opened, &std::unique_ptr<Client>::operator*))
    readWhatHasCome(poll, room);
  const auto start = Clock::now(), end = start + std::chrono::seconds(number(6));
  for (const auto& client : clients) client->begin();
  while (Clock::now() < end) readWhatHasCome(poll, room);
  close(poll);
  SSL_CTX_free(tls);
  print(clients, std::chrono::duration<double>(Clock::now() - start).count());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 8 && argc != 9) {
    std::fprintf(stderr, "usage: serving_load PORT MODEL FIRST LAST CONNECTIONS IN_FLIGHT SECONDS [tls]\n");
    return 2;
  }
  try {
    run(std::span(argv + 1, static_cast<size_t>(argc - 1)));
    return 0;
  } catch (const lode::Error& error) {
    std::fprintf(stderr, "serving_load: %s\n", error.what());
    return 1;
  }
}
