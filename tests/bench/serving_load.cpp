// Takes as much as a server gives: serving_load PORT MODEL FIRST LAST CONNECTIONS IN_FLIGHT SECONDS. Each
// connection keeps so many wishes open for blobs from FIRST to LAST, at random. It looks at headers and drops
// the bytes, so that one core of it does not hold up one of the server. Prints blobs, bytes and the seconds
// that they took.
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
#include <netinet/tcp.h>
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

struct Tally {
  uint64_t blobs = 0, bytes = 0;
};

class Client {
 public:
  Client(uint16_t port, const std::string& model, uint32_t first, uint32_t last, uint32_t in_flight,
         uint32_t seed)
      : socket_(socket(AF_INET, SOCK_STREAM, 0)), any_(first, last), in_flight_(in_flight), random_(seed) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
      throw Error(ErrorCode::kNetwork, "cannot connect to port " + std::to_string(port));
    send(proto::encode(proto::Hello{1, 1, 0, "", "serving_load"}, 1));
    send(proto::encode(proto::Open{model, {}}, 2));
    send(proto::encode(proto::Credit{kEndlessWindow}, 0));
  }
  ~Client() { close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  int descriptor() const noexcept { return socket_; }

  /// @param room  for what is read in one go; shared by all clients.
  void read(std::span<std::byte> room, Tally& tally) {
    const ssize_t got = recv(socket_, room.data(), room.size(), MSG_DONTWAIT);
    if (got == 0) throw Error(ErrorCode::kNetwork, "the server closed a connection");
    if (got < 0) return;
    take(room.first(static_cast<size_t>(got)), tally);
    if (opened_ && open_ + kRefill <= in_flight_) wish();
  }

 private:
  static constexpr uint32_t kRefill = 8;  ///< wishes in a frame
  static constexpr size_t kHeadBytes = proto::kFrameHeaderBytes + proto::kBlobChunkHeaderBytes;

  void send(const proto::Bytes& frame) {
    if (::send(socket_, frame.data(), frame.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(frame.size()))
      throw Error(ErrorCode::kNetwork, "a connection broke");
  }
  void wish() {
    proto::Wishes wishes{1, {}};
    for (; open_ < in_flight_; ++open_)
      wishes.changes.push_back(
          {proto::WishAction::kAdd, proto::WishClass::kVisible, ++last_wish_, any_(random_), 1});
    send(proto::encode(wishes, 3));
  }
  /// Frames may be cut anywhere: heads are put together, bodies skipped.
  void take(std::span<const std::byte> bytes, Tally& tally) {
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
      if (wanted_fields_ > 0) readChunk(tally);
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
  void readChunk(Tally& tally) {
    const auto u32 = [this](size_t at) {
      uint32_t value = 0;
      for (size_t i = 4; i-- > 0;)
        value = value << 8 | std::to_integer<uint32_t>(head_[proto::kFrameHeaderBytes + at + i]);
      return value;
    };
    const auto bytes = static_cast<uint32_t>(body_bytes_ - proto::kBlobChunkHeaderBytes);
    tally.bytes += bytes;
    if (u32(8) + bytes < u32(4) || u32(0) == 0) return;
    ++tally.blobs;
    --open_;
  }

  int socket_;
  std::uniform_int_distribution<uint32_t> any_;
  uint32_t in_flight_, open_ = 0, last_wish_ = 0;
  std::mt19937 random_;
  std::array<std::byte, kHeadBytes> head_;
  size_t head_used_ = 0, wanted_fields_ = 0, body_bytes_ = 0, skip_ = 0;
  bool opened_ = false;
};

void run(std::span<char*> arguments) {
  const auto number = [&](size_t i) {
    return static_cast<uint32_t>(std::strtoul(arguments[i], nullptr, 10));
  };
  std::vector<std::unique_ptr<Client>> clients;
  const int poll = epoll_create1(0);
  for (uint32_t i = 0; i < number(4); ++i) {
    clients.push_back(std::make_unique<Client>(static_cast<uint16_t>(number(0)), arguments[1], number(2),
                                               number(3), number(5), i + 1));
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = clients.back().get();
    epoll_ctl(poll, EPOLL_CTL_ADD, clients.back()->descriptor(), &event);
  }
  std::vector<std::byte> room(256u << 10);
  Tally tally;
  const auto start = Clock::now(), end = start + std::chrono::seconds(number(6));
  while (Clock::now() < end) {
    std::array<epoll_event, 256> events;
    const int count = epoll_wait(poll, events.data(), static_cast<int>(events.size()), 100);
    for (int i = 0; i < count; ++i)
      static_cast<Client*>(events[static_cast<size_t>(i)].data.ptr)->read(room, tally);
  }
  close(poll);
  std::printf("{\"blobs\": %llu, \"bytes\": %llu, \"seconds\": %.3f}\n",
              static_cast<unsigned long long>(tally.blobs), static_cast<unsigned long long>(tally.bytes),
              std::chrono::duration<double>(Clock::now() - start).count());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 8) {
    std::fprintf(stderr, "usage: serving_load PORT MODEL FIRST LAST CONNECTIONS IN_FLIGHT SECONDS\n");
    return 2;
  }
  try {
    run(std::span(argv + 1, 7));
    return 0;
  } catch (const lode::Error& error) {
    std::fprintf(stderr, "serving_load: %s\n", error.what());
    return 1;
  }
}
