#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/error.h"

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
/// An error with the server that it is about before it, unless it names that already.
Error naming(const Address& server, const Error& error);

}  // namespace lode::net
