#include "server/serve/net/listen_address.h"

#include <charconv>

#include "common/error.h"
#include "proto/limits.h"

namespace lode::serve {

ListenAddress parseListenAddress(std::string_view text) {
  const auto wrong = [&] {
    return Error(
        ErrorCode::kUsage,
        "'" + std::string(text) + "' is no address to listen on; write it as 127.0.0.1:7400 or [::1]:7400");
  };
  std::string_view host = text, port;
  if (text.starts_with('[')) {
    const size_t end = text.find(']');
    if (end == std::string_view::npos) throw wrong();
    host = text.substr(1, end - 1);
    port = text.substr(end + 1);
    if (!port.empty() && !port.starts_with(':')) throw wrong();
  } else if (const size_t colon = text.find(':'); colon != std::string_view::npos) {
    host = text.substr(0, colon);
    port = text.substr(colon);
  }
  // A number alone is a port that somebody gave without its address, and the system takes it for an address.
  if (host.find_first_not_of("0123456789") == std::string_view::npos) throw wrong();
  ListenAddress address{std::string(host), proto::kDefaultPort};
  if (port.empty()) return address;
  const char* const end = port.data() + port.size();
  const auto [stop, error] = std::from_chars(port.data() + 1, end, address.port);
  if (error != std::errc() || stop != end) throw wrong();
  return address;
}

}  // namespace lode::serve
