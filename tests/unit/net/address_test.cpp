#include "client/net/address.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "proto/limits.h"

namespace lode::net {
namespace {

TEST(Address, readsHostsWithAndWithoutAPort) {
  EXPECT_EQ(parseAddress("example.org:81"), (Address{"example.org", 81}));
  EXPECT_EQ(parseAddress("10.0.0.1"), (Address{"10.0.0.1", proto::kDefaultPort}));
  EXPECT_EQ(parseAddress("[::1]:7"), (Address{"::1", 7}));
  EXPECT_EQ(parseAddress("[fe80::1%2]"), (Address{"fe80::1%2", proto::kDefaultPort}));
}

TEST(Address, refusesInvalidAddresses) {
  for (const char* text : {"", ":80", "host:", "host:0", "host:65536", "host:-1", "host:8x", "ho st", "a:1:2",
                           "[::1", "[::1]x", "[]", "[name]", "[::1]:", "a/b", "host:99999999999999999999"})
    EXPECT_THROW(parseAddress(text), Error) << text;
  EXPECT_THROW(parseAddress(std::string(300, 'a')), Error);
}

TEST(Address, isPrependedToAnErrorThatDoesNotNameIt) {
  const Address server{"example.org", 81};
  const auto naming = [&](const char* what) {
    return std::string(net::naming(server, Error(ErrorCode::kNetwork, what)).what());
  };
  EXPECT_EQ(naming("it broke"), "example.org:81: it broke");
  EXPECT_EQ(naming("no answer from example.org:81"), "no answer from example.org:81");
  const Error refused(ErrorCode::kInput, "no token", Remedy::kToken);
  EXPECT_EQ(net::naming(server, refused).remedy(), Remedy::kToken);
}

TEST(Address, isWrittenAsItIsRead) {
  for (const char* text : {"example.org:81", "[::1]:7"}) EXPECT_EQ(toString(parseAddress(text)), text);
}

}  // namespace
}  // namespace lode::net
