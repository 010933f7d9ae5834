#include "server/serve/net/proxy_header.h"

#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::serve {
namespace {

std::optional<ProxyHeader> parse(std::string_view text) {
  return parseProxyHeader(std::as_bytes(std::span(text)));
}

std::string headerRefusal(std::string_view text) {
  try {
    parse(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

/// @param command  0x20 local, 0x21 proxied. @param family  0x11 TCP4, 0x21 TCP6.
std::string binary(char command, char family, const std::string& rest) {
  return std::string("\r\n\r\n\0\r\nQUIT\n", 12) + command + family + static_cast<char>(rest.size() >> 8) +
         static_cast<char>(rest.size() & 255) + rest;
}

const std::string kFour("\xC0\x00\x02\x07\x7F\x00\x00\x01\x12\x34\x1C\xE8", 12);

void expectClient(const std::string& header, const std::string& address) {
  const auto parsed = parse(header + "what the client says");
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->bytes, header.size());
  ASSERT_TRUE(parsed->client);
  EXPECT_EQ(parsed->client->to_string(), address);
}

void expectNobody(const std::string& header) {
  const auto parsed = parse(header + "x");
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->bytes, header.size());
  EXPECT_FALSE(parsed->client);
}

TEST(ProxyHeader, namesTheClientInText) {
  expectClient("PROXY TCP4 192.0.2.7 127.0.0.1 4660 7400\r\n", "192.0.2.7");
  expectClient("PROXY TCP6 2001:db8::1 ::1 65535 7400\r\n", "2001:db8::1");
}

TEST(ProxyHeader, namesTheClientInBinary) {
  expectClient(binary(0x21, 0x11, kFour), "192.0.2.7");
  std::string six(36, '\0');
  six[0] = 0x20;
  six[1] = 0x01;
  six[15] = 9;
  expectClient(binary(0x21, 0x21, six), "2001::9");
}

TEST(ProxyHeader, skipsExtraFieldsAfterTheAddresses) {
  expectClient(binary(0x21, 0x11,
                      kFour + std::string("\x04\x00\x03"
                                          "abc",
                                          6)),
               "192.0.2.7");
}

TEST(ProxyHeader, givesNoClientForTheBalancersOwnConnection) {
  expectNobody("PROXY UNKNOWN\r\n");
  expectNobody("PROXY UNKNOWN ffff::1 ffff::2 1 2\r\n");
  expectNobody(binary(0x20, 0x00, ""));
  expectNobody(binary(0x20, 0x11, kFour));
  expectNobody(binary(0x21, 0x31, std::string(216, 'u')));
}

TEST(ProxyHeader, isAwaitedByteByByte) {
  for (const std::string& header : {std::string("PROXY TCP4 192.0.2.7 127.0.0.1 4660 7400\r\n"),
                                    binary(0x21, 0x11, kFour), std::string("PROXY UNKNOWN\r\n")}) {
    for (size_t length = 0; length < header.size(); ++length)
      EXPECT_FALSE(parse(std::string_view(header).substr(0, length))) << length;
    EXPECT_TRUE(parse(header));
  }
}

TEST(ProxyHeader, isRefusedAtTheFirstInvalidByte) {
  EXPECT_NE(headerRefusal(std::string_view("\x38\0\0\0\1", 5)).find("does not begin with one"),
            std::string::npos);
  EXPECT_NE(headerRefusal("GET / HTTP/1.1").find("does not begin with one"), std::string::npos);
  EXPECT_NE(headerRefusal("PROXZ").find("does not begin with one"), std::string::npos);
}

TEST(ProxyHeader, isRefusedWithAnInvalidLine) {
  for (const char* line :
       {"PROXY TCP5 1.1.1.1 1.1.1.1 1 1\r\n", "PROXY TCP4 1.1.1 1.1.1.1 1 1\r\n",
        "PROXY TCP4 ::1 ::1 1 1\r\n", "PROXY TCP6 1.1.1.1 1.1.1.1 1 1\r\n",
        "PROXY TCP4 1.1.1.1 1.1.1.1 65536 1\r\n", "PROXY TCP4 1.1.1.1 1.1.1.1 1\r\n",
        "PROXY TCP4 1.1.1.1 1.1.1.1 1 1 1\r\n", "PROXY TCP4  1.1.1.1 1.1.1.1 1 1\r\n", "PROXY \r\n"})
    EXPECT_NE(headerRefusal(line), "accepted") << line;
}

TEST(ProxyHeader, isRefusedWithoutAnEndAtItsLimit) {
  const std::string endless = "PROXY UNKNOWN " + std::string(200, 'x');
  EXPECT_FALSE(parse(std::string_view(endless).substr(0, 106)));
  EXPECT_NE(headerRefusal(endless.substr(0, 107)).find("does not end"), std::string::npos);
}

TEST(ProxyHeader, isRefusedInBinaryWithAnInvalidHead) {
  EXPECT_NE(headerRefusal(binary(0x11, 0x11, kFour)).find("version or command"), std::string::npos);
  EXPECT_NE(headerRefusal(binary(0x22, 0x11, kFour)).find("version or command"), std::string::npos);
  EXPECT_NE(headerRefusal(binary(0x21, 0x11, kFour.substr(0, 11))).find("cut off"), std::string::npos);
  EXPECT_NE(headerRefusal(binary(0x21, 0x21, std::string(35, 'x'))).find("cut off"), std::string::npos);
  EXPECT_NE(headerRefusal(binary(0x21, 0x11, std::string(3000, 'x'))).find("the limit is 2048"),
            std::string::npos);
}

}  // namespace
}  // namespace lode::serve
