#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lode::net {

struct Address {
  std::string host;  ///< name or number, without brackets
  uint16_t port = 0;
  bool operator==(const Address&) const = default;
};

/// "host:port", "host", "[v6]:port". @throws Error kUsage.
Address parseAddress(std::string_view text);
/// With brackets where needed.
std::string toString(const Address& address);

}  // namespace lode::net
