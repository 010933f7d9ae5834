#pragma once

#include <string>

#include "client/net/address.h"

namespace lode::stream {

/// lode://host[:port]/model
struct ServedModel {
  net::Address address;
  std::string model;
  bool operator==(const ServedModel&) const = default;
};

}  // namespace lode::stream
