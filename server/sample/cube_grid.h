#pragma once

#include <array>
#include <cstdint>

namespace lode::ingest {

/// The surface of a cube as a grid of n x n squares a side, vertices shared: 6 n^2 + 2 vertices, 6 n^2
/// squares, all numbered by formula. Vertices come in layers of z from 0 to n: all of the lowest, rings, all
/// of the highest.
class CubeGrid {
 public:
  explicit CubeGrid(uint64_t n) : n_(n) {}

  uint64_t vertices() const noexcept { return 6 * n_ * n_ + 2; }
  uint64_t squares() const noexcept { return 6 * n_ * n_; }

  /// Coordinates 0..n of a vertex.
  std::array<uint32_t, 3> vertex(uint64_t number) const noexcept {
    const uint64_t layer = (n_ + 1) * (n_ + 1);
    const uint64_t rings = 4 * n_ * (n_ - 1);
    if (number >= layer && number < layer + rings) {
      const uint64_t in_rings = number - layer;
      return ringVertex(in_rings / (4 * n_) + 1, in_rings % (4 * n_));
    }
    const bool top = number >= layer;
    const uint64_t in_layer = top ? number - layer - rings : number;
    return {static_cast<uint32_t>(in_layer % (n_ + 1)), static_cast<uint32_t>(in_layer / (n_ + 1)),
            static_cast<uint32_t>(top ? n_ : 0)};
  }

  /// Vertex numbers of a square, counter-clockwise seen from outside.
  std::array<uint32_t, 4> square(uint64_t number) const noexcept {
    const uint64_t face = n_ * n_;
    if (number < face) {
      const auto [a, b, c, d] = flatSquare(number, 0);
      return {a, d, c, b};
    }
    if (number >= 5 * face) return flatSquare(number - 5 * face, (n_ + 1) * (n_ + 1) + 4 * n_ * (n_ - 1));
    const uint64_t z = (number - face) / (4 * n_);
    const uint64_t along = (number - face) % (4 * n_);
    const uint64_t next = along + 1 == 4 * n_ ? 0 : along + 1;
    return {ringNumber(z, along), ringNumber(z, next), ringNumber(z + 1, next), ringNumber(z + 1, along)};
  }

 private:
  /// A ring goes round the four sides, counter-clockwise seen from above.
  std::array<uint32_t, 3> ringVertex(uint64_t z, uint64_t along) const noexcept {
    const uint64_t at = along % n_;
    const auto point = [&](uint64_t x, uint64_t y) {
      return std::array<uint32_t, 3>{static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                     static_cast<uint32_t>(z)};
    };
    switch (along / n_) {
      case 0:
        return point(at, 0);
      case 1:
        return point(n_, at);
      case 2:
        return point(n_ - at, n_);
      default:
        return point(0, n_ - at);
    }
  }

  uint32_t ringNumber(uint64_t z, uint64_t along) const noexcept {
    const uint64_t layer = (n_ + 1) * (n_ + 1);
    if (z > 0 && z < n_) return static_cast<uint32_t>(layer + (z - 1) * 4 * n_ + along);
    const std::array<uint32_t, 3> at = ringVertex(z, along);
    return static_cast<uint32_t>((z == 0 ? 0 : layer + 4 * n_ * (n_ - 1)) + at[1] * (n_ + 1) + at[0]);
  }

  std::array<uint32_t, 4> flatSquare(uint64_t number, uint64_t first_vertex) const noexcept {
    const uint64_t a = first_vertex + number / n_ * (n_ + 1) + number % n_;
    return {static_cast<uint32_t>(a), static_cast<uint32_t>(a + 1), static_cast<uint32_t>(a + n_ + 2),
            static_cast<uint32_t>(a + n_ + 1)};
  }

  uint64_t n_;
};

}  // namespace lode::ingest
