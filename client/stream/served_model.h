#pragma once

#include <string>
#include <string_view>

#include "client/net/address.h"

namespace lode::stream {

/// lode://host[:port]/model, or lodes:// for one behind TLS.
struct ServedModel {
  net::Address address;
  std::string model;
  bool encrypted = false;
  bool operator==(const ServedModel&) const = default;
};

/// As a user writes it.
inline std::string toString(const ServedModel& served) {
  return (served.encrypted ? "lodes://" : "lode://") + net::toString(served.address) + '/' + served.model;
}

/// lode://host[:port]/model, or lodes:// for one behind TLS. @throws Error kUsage for what is none.
ServedModel parseServedModel(std::string_view url);
/// lode://host[:port] or lodes://host[:port] without a model, whose name stays empty. @throws Error kUsage.
ServedModel parseServer(std::string_view url);

}  // namespace lode::stream
