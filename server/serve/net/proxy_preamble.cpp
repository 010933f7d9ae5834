#include "server/serve/net/proxy_preamble.h"

#include <array>
#include <string>
#include <vector>

#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

#include "common/error.h"

namespace lode::serve {

using asio::ip::tcp;

asio::awaitable<std::optional<ProxyHeader>> readProxyHeader(tcp::socket& socket) {
  const auto broken = [](const std::string& why) { return Error(ErrorCode::kNetwork, why); };
  socket.non_blocking(true);
  std::vector<std::byte> header;  // what was taken from the socket
  while (true) {
    asio::error_code error;
    co_await socket.async_wait(tcp::socket::wait_read, asio::redirect_error(asio::use_awaitable, error));
    if (error) throw broken("the connection broke in the balancer's header: " + error.message());
    const size_t taken = header.size();
    header.resize(kMaxProxyHeaderBytes);
    const size_t seen = socket.receive(asio::buffer(header.data() + taken, header.size() - taken),
                                       tcp::socket::message_peek, error);
    header.resize(taken + seen);
    if (error == asio::error::would_block) continue;
    if (error == asio::error::eof && taken == 0) co_return std::nullopt;
    if (error == asio::error::eof) throw broken("the connection ended in the balancer's header");
    if (error) throw broken("the connection broke in the balancer's header: " + error.message());
    std::optional<ProxyHeader> parsed;
    try {
      parsed = parseProxyHeader(header);
    } catch (const Error& wrong) {
      throw broken(wrong.what());
    }
    const size_t take = parsed ? parsed->bytes - taken : seen;
    socket.receive(asio::buffer(header.data() + taken, take), 0, error);  // they are there: they were seen
    if (error) throw broken("the connection broke in the balancer's header: " + error.message());
    if (parsed) co_return parsed;
  }
}

}  // namespace lode::serve
