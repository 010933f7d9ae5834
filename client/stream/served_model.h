#pragma once

#include <string>
#include <string_view>

#include "client/net/address.h"

namespace lode::stream {

/// Address of a model on a server: lode://host[:port]/model, or lodes:// with TLS.
struct ServedModel {
  net::Address address;
  std::string model;
  bool encrypted = false;
  bool operator==(const ServedModel&) const = default;
};

/// Returns the model's URL.
inline std::string toString(const ServedModel& served) {
  return (served.encrypted ? "lodes://" : "lode://") + net::toString(served.address) + '/' + served.model;
}

/// Parses lode://host[:port]/model or lodes://host[:port]/model. @throws Error kUsage.
ServedModel parseServedModel(std::string_view url);
/// Parses lode://host[:port] or lodes://host[:port]; the model name stays empty. @throws Error kUsage.
ServedModel parseServer(std::string_view url);

}  // namespace lode::stream
