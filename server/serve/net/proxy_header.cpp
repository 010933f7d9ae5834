#include "server/serve/net/proxy_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

#include "common/error.h"

namespace lode::serve {

using asio::ip::tcp;

namespace {

constexpr std::string_view kTextStart = "PROXY ";
constexpr std::string_view kBinaryStart("\r\n\r\n\0\r\nQUIT\n", 12);
constexpr size_t kMaxTextBytes = 107;  ///< largest size of a version 1 header, line end included
constexpr size_t kBinaryHeadBytes = 16;

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorCode::kProtocol, "a connection has no valid PROXY header: " + what +
                                        "; with --proxy-protocol connect through a balancer that sends one");
}

/// Returns true if one of the texts is a prefix of the other.
bool agrees(std::string_view text, std::string_view start) {
  const size_t common = std::min(text.size(), start.size());
  return text.substr(0, common) == start.substr(0, common);
}

std::string_view nextWord(std::string_view& line) {
  const size_t end = std::min(line.find(' '), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(std::min(end + 1, line.size()));
  return word;
}

asio::ip::address parseAddress(std::string_view text, bool v6) {
  asio::error_code error;
  const asio::ip::address address = asio::ip::make_address(std::string(text), error);
  if (error || address.is_v6() != v6) refuse("an address is malformed");
  return address;
}

void checkPort(std::string_view text) {
  uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size()) refuse("a port is malformed");
}

/// @param line  header without the line end.
std::optional<asio::ip::address> parseTextLine(std::string_view line) {
  line.remove_prefix(kTextStart.size());
  const std::string_view family = nextWord(line);
  if (family == "UNKNOWN") return {};
  if (family != "TCP4" && family != "TCP6") refuse("its family is not TCP4, TCP6 or UNKNOWN");
  const bool v6 = family == "TCP6";
  const asio::ip::address client = parseAddress(nextWord(line), v6);
  parseAddress(nextWord(line), v6);
  checkPort(nextWord(line));
  checkPort(nextWord(line));
  if (!line.empty()) refuse("its line has more after the ports");
  return client;
}

std::optional<ProxyHeader> parseText(std::string_view text) {
  const size_t end = text.substr(0, kMaxTextBytes).find("\r\n");
  if (end == std::string_view::npos) {
    if (text.size() >= kMaxTextBytes) refuse("its line does not end");
    return {};
  }
  if (end < kTextStart.size()) refuse("its line is cut off");
  return ProxyHeader{end + 2, parseTextLine(text.substr(0, end))};
}

/// Returns the client's address in a version 2 header, or nothing if the family is not TCP.
std::optional<asio::ip::address> binaryClient(uint8_t family, std::string_view addresses) {
  constexpr uint8_t kTcp4 = 0x11, kTcp6 = 0x21;
  const auto read = [&]<typename Bytes>(Bytes bytes, size_t both_and_ports) {
    if (addresses.size() < both_and_ports) refuse("its addresses are cut off");
    std::memcpy(bytes.data(), addresses.data(), bytes.size());
    return bytes;
  };
  if (family == kTcp4) return asio::ip::address_v4(read(asio::ip::address_v4::bytes_type(), 12));
  if (family == kTcp6) return asio::ip::address_v6(read(asio::ip::address_v6::bytes_type(), 36));
  return {};
}

std::optional<ProxyHeader> parseBinary(std::string_view bytes) {
  if (bytes.size() < kBinaryHeadBytes) return {};
  const auto at = [bytes](size_t i) { return static_cast<uint8_t>(bytes[i]); };
  const size_t length = size_t{at(14)} << 8 | at(15);
  const uint8_t version_and_command = at(12);
  if (version_and_command != 0x20 && version_and_command != 0x21) refuse("its version or command is unknown");
  if (kBinaryHeadBytes + length > kMaxProxyHeaderBytes)
    throw Error(ErrorCode::kLimit, "a PROXY header of " + std::to_string(kBinaryHeadBytes + length) +
                                       " bytes; the limit is " + std::to_string(kMaxProxyHeaderBytes));
  if (bytes.size() < kBinaryHeadBytes + length) return {};
  ProxyHeader header{kBinaryHeadBytes + length, {}};
  const bool local = version_and_command == 0x20;
  if (!local) header.client = binaryClient(at(13), bytes.substr(kBinaryHeadBytes, length));
  return header;
}

}  // namespace

std::optional<ProxyHeader> parseProxyHeader(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (agrees(text, kBinaryStart)) return parseBinary(text);
  if (agrees(text, kTextStart)) return parseText(text);
  refuse("it does not begin with one");
}

asio::awaitable<std::optional<ProxyHeader>> readProxyHeader(tcp::socket& socket) {
  const auto broken = [](const std::string& why) { return Error(ErrorCode::kNetwork, why); };
  socket.non_blocking(true);
  std::vector<std::byte> header;  // all bytes taken from the socket so far
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
    socket.receive(asio::buffer(header.data() + taken, take), 0,
                   error);  // the read cannot block, because peeking has shown that the bytes are there
    if (error) throw broken("the connection broke in the balancer's header: " + error.message());
    if (parsed) co_return parsed;
  }
}

}  // namespace lode::serve
