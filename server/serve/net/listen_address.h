#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lode::serve {

struct ListenAddress {
  std::string host;
  uint16_t port = 0;
};

/// "127.0.0.1:7400", "[::1]:7400", "localhost:0"; without a port, kDefaultPort.
/// @throws Error kUsage.
ListenAddress parseListenAddress(std::string_view text);

}  // namespace lode::serve
