#pragma once

#include <string_view>

namespace lode::http {

/// Returns the media type of a file by the ending of its name. Thread safe.
std::string_view contentTypeOf(std::string_view name) noexcept;

}  // namespace lode::http
