#include "server/http/tileset.h"

#include <span>
#include <utility>

#include "common/error.h"
#include "common/up_axis.h"
#include "server/http/gzip.h"
#include "server/store/export.h"
#include "server/tiles/tile_frame.h"

namespace lode::http {

namespace {

constexpr std::string_view kRootFile = "tileset.json";

glm::dmat4 rootTransformOf(const store::Reader& store) {
  const Node& root = store.nodes().front();
  const auto coarsest = static_cast<uint32_t>(root.lods.size() - 1);
  return tiles::rootTransform(store.summary(), guessUp(store::readLod(store, root, coarsest)), {});
}

std::unique_ptr<const Content> jsonFile(const std::string& json) {
  const auto bytes = std::as_bytes(std::span(json));
  return std::make_unique<FileContent>(std::vector<std::byte>(bytes.begin(), bytes.end()), gzip(bytes));
}

}  // namespace

Tileset::Tileset(std::shared_ptr<const store::Reader> store)
    : store_(std::move(store)), writer_(*store_, rootTransformOf(*store_)), index_(*store_, writer_) {}

bool Tileset::has(std::string_view file) const {
  return file == kRootFile || index_.findPage(file) || index_.findGlb(file) || index_.findImage(file);
}

std::unique_ptr<const Content> Tileset::make(std::string_view file) const {
  if (file == kRootFile) return jsonFile(writer_.page(kRootKey).json);
  if (const auto owner = index_.findPage(file)) return jsonFile(writer_.page(*owner).json);
  if (const auto image = index_.findImage(file))
    return std::make_unique<FileContent>(writer_.image(*image), std::vector<std::byte>());
  const auto item = index_.findGlb(file);
  if (!item) throw Error(ErrorCode::kInternal, "a tileset has no file " + std::string(file));
  return std::make_unique<FileContent>(writer_.glb(*item).bytes, std::vector<std::byte>());
}

}  // namespace lode::http
