#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <variant>

#include "client/net/address.h"

namespace lode::app {

/// lode://host[:port]/model
struct ServedModel {
  net::Address address;
  std::string model;
  bool operator==(const ServedModel&) const = default;
};

/// What a command works on: a model on a server, or a local file that a child server will serve.
struct StoreFile {
  std::filesystem::path path;
};
struct PlyFile {
  std::filesystem::path path;
};
using Target = std::variant<ServedModel, StoreFile, PlyFile>;

/// @throws Error kUsage for what cannot be a target, kIo for a file that is not there.
Target parseTarget(std::string_view text);
/// lode://host[:port] without a model. @throws Error kUsage.
net::Address parseServerUrl(std::string_view text);

}  // namespace lode::app
