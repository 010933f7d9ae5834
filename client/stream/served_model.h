#pragma once

#include <string>

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

}  // namespace lode::stream
