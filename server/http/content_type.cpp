#include "server/http/content_type.h"

#include <array>
#include <utility>

namespace lode::http {

std::string_view contentTypeOf(std::string_view name) noexcept {
  using Entry = std::pair<std::string_view, std::string_view>;
  static constexpr std::array<Entry, 11> kTypes{{{".html", "text/html; charset=utf-8"},
                                                 {".css", "text/css; charset=utf-8"},
                                                 {".js", "text/javascript; charset=utf-8"},
                                                 {".wasm", "application/wasm"},
                                                 {".json", "application/json"},
                                                 {".txt", "text/plain; charset=utf-8"},
                                                 {".svg", "image/svg+xml"},
                                                 {".png", "image/png"},
                                                 {".jpg", "image/jpeg"},
                                                 {".webp", "image/webp"},
                                                 {".glb", "model/gltf-binary"}}};
  for (const auto& [ending, type] : kTypes)
    if (name.ends_with(ending)) return type;
  return "application/octet-stream";
}

}  // namespace lode::http
