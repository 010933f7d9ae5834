#pragma once

#include <string_view>

#include "client/stream/served_model.h"

namespace lode::stream {

/// lode://host[:port]/model, or lodes:// for one behind TLS. @throws Error kUsage for what is none.
ServedModel parseServedModel(std::string_view url);
/// lode://host[:port] or lodes://host[:port] without a model, whose name stays empty. @throws Error kUsage.
ServedModel parseServer(std::string_view url);

}  // namespace lode::stream
