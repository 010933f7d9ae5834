#include "server/tiles/atlas.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <tuple>

#include "server/tiles/texel_fill.h"

namespace lode::tiles {
namespace {

auto orderOf(const AtlasPiece& piece) {
  return std::tuple(piece.texture, piece.level, piece.first.x, piece.first.y, piece.end.x, piece.end.y);
}

AtlasPiece around(const AtlasPiece& a, const AtlasPiece& b) {
  AtlasPiece both = a;
  both.first = glm::min(a.first, b.first);
  both.end = glm::max(a.end, b.end);
  return both;
}

bool overlap(const AtlasPiece& a, const AtlasPiece& b) {
  return glm::all(glm::lessThan(glm::max(a.first, b.first), glm::min(a.end, b.end)));
}

/// Joins each piece with the later pieces that overlap it. @return true if a piece was joined.
bool joinOnce(std::vector<AtlasPiece>& pieces, std::vector<uint32_t>& owners) {
  std::vector<uint32_t> order(pieces.size()), into(pieces.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](uint32_t i) { return std::tuple(orderOf(pieces[i]), i); });
  std::vector<AtlasPiece> kept;
  std::vector<bool> is_joined(pieces.size());
  for (size_t i = 0; i < order.size(); ++i) {
    if (is_joined[order[i]]) continue;
    AtlasPiece piece = pieces[order[i]];
    into[order[i]] = static_cast<uint32_t>(kept.size());
    for (size_t j = i + 1; j < order.size(); ++j) {
      const AtlasPiece& other = pieces[order[j]];
      if (other.texture != piece.texture || other.level != piece.level || other.first.x >= piece.end.x) break;
      if (is_joined[order[j]] || !overlap(piece, other)) continue;
      const AtlasPiece both = around(piece, other);
      if (both.area() > piece.area() + other.area()) continue;
      piece = both;
      is_joined[order[j]] = true;
      into[order[j]] = static_cast<uint32_t>(kept.size());
    }
    kept.push_back(piece);
  }
  for (uint32_t& owner : owners) owner = into[owner];
  const bool any = kept.size() < pieces.size();
  pieces = std::move(kept);
  return any;
}

}  // namespace

std::vector<uint32_t> joinPieces(std::vector<AtlasPiece>& pieces) {
  std::vector<uint32_t> owners(pieces.size());
  std::iota(owners.begin(), owners.end(), 0u);
  while (joinOnce(pieces, owners)) continue;
  return owners;
}

glm::uvec2 placePieces(std::span<AtlasPiece> pieces) {
  // Fills rows ("shelves") from the highest piece to the lowest.
  std::vector<AtlasPiece*> order;
  uint64_t area = 0;
  uint32_t widest = 1;
  for (AtlasPiece& piece : pieces) {
    order.push_back(&piece);
    area += piece.area();
    widest = std::max(widest, piece.size().x);
  }
  std::ranges::sort(order, [](const AtlasPiece* a, const AtlasPiece* b) {
    return std::tuple(b->size().y, b->size().x, orderOf(*a)) <
           std::tuple(a->size().y, a->size().x, orderOf(*b));
  });
  const auto edge = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(area))));
  const uint32_t width = std::max(widest, edge);
  glm::uvec2 at(0), size(0);
  uint32_t shelf = 0;
  for (AtlasPiece* const piece : order) {
    const glm::uvec2 wanted = piece->size();
    if (at.x + wanted.x > width) at = {0, at.y + std::exchange(shelf, 0)};
    piece->place = at;
    at.x += wanted.x;
    shelf = std::max(shelf, wanted.y);
    size = glm::max(size, piece->place + wanted);
  }
  return size;
}

Atlas paintAtlas(std::span<const AtlasPiece> pieces, glm::uvec2 size, TextureLevels& levels) {
  Atlas atlas{{size, std::vector<glm::u8vec4>(size_t{size.x} * size.y, glm::u8vec4(0))}};
  std::vector<bool> is_known(atlas.image.texels.size()), is_covered(atlas.image.texels.size());
  for (const AtlasPiece& piece : pieces) {
    const Image part = levels.part(piece.texture, piece.level, piece.first, piece.size());
    for (uint32_t y = 0; y < part.size.y; ++y)
      for (uint32_t x = 0; x < part.size.x; ++x) {
        const size_t to = size_t{piece.place.y + y} * size.x + piece.place.x + x;
        const glm::u8vec4 texel = atlas.image.texels[to] = part.at(x, y);
        is_covered[to] = true;
        is_known[to] = texel.a > 0;
        atlas.is_clear |= texel.a < 255;
      }
  }
  fillUnknown(atlas.image, is_known);
  if (!atlas.is_clear)
    for (size_t i = 0; i < is_covered.size(); ++i)
      if (!is_covered[i]) atlas.image.texels[i].a = 255;
  return atlas;
}

}  // namespace lode::tiles
