#include "server/serve/refusals.h"

#include <array>
#include <utility>

namespace lode::serve {

namespace {

using asio::ip::tcp;

/// Drops what has come. @return whether the peer has closed its side, or the connection is broken.
bool drop(tcp::socket& socket) {
  std::array<std::byte, 4096> room;
  asio::error_code error;
  for (int i = 0; i < 16; ++i) {  // a flood is not waited for
    socket.read_some(asio::buffer(room), error);
    if (error) break;
  }
  return error && error != asio::error::would_block;
}

void say(tcp::socket& socket, std::span<const std::byte> last_word) {
  asio::error_code ignored;
  socket.non_blocking(true, ignored);
  socket.write_some(asio::buffer(last_word.data(), last_word.size()),
                    ignored);  // a new socket has room for it
  socket.shutdown(tcp::socket::shutdown_send, ignored);
}

}  // namespace

void Refusals::refuse(tcp::socket socket, std::span<const std::byte> last_word, Clock::time_point now) {
  say(socket, last_word);
  if (lingering_.size() >= kMost) lingering_.pop_front();
  lingering_.push_back({std::move(socket), now + kLinger});
}

void Refusals::refuseAtOnce(tcp::socket socket, std::span<const std::byte> last_word) {
  say(socket, last_word);
  drop(socket);
}

void Refusals::sweep(Clock::time_point now) {
  std::erase_if(lingering_, [&](Lingering& refused) { return drop(refused.socket) || now >= refused.until; });
}

}  // namespace lode::serve
