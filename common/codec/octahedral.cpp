#include "common/codec/octahedral.h"

#include <cmath>
#include <cstdlib>

namespace lode {
namespace {

constexpr int kCentre = 127;        // coordinate of the square's centre, which encodes the direction +x
constexpr int kLast = 2 * kCentre;  // largest coordinate; 254 instead of 255, so that the square has a centre

// Returns the code that encoders use for the direction of p. Each direction on an edge of the square has two
// codes, because the halves of an edge mirror each other. All four corners denote -x. Encoders use the lower
// half of the left edge, the left half of the lower edge, the upper half of the right edge, the right half of
// the upper edge, and the upper right corner.
glm::ivec2 canonical(glm::ivec2 p) noexcept {
  const bool left = p.x == 0, right = p.x == kLast, bottom = p.y == 0, top = p.y == kLast;
  if ((left || right) && (bottom || top)) return glm::ivec2(kLast);
  if ((left && p.y > kCentre) || (right && p.y < kCentre)) p.y = kLast - p.y;
  if ((top && p.x < kCentre) || (bottom && p.x > kCentre)) p.x = kLast - p.x;
  return p;
}

double lengthOnOctahedron(glm::dvec3 vector) noexcept {
  return std::abs(vector.x) + std::abs(vector.y) + std::abs(vector.z);
}

// Rounds a direction to a point with integer coordinates on the octahedron |x| + |y| + |z| = kCentre.
glm::ivec3 toIntegerOctahedron(glm::dvec3 direction) noexcept {
  glm::ivec3 p;
  p.x = static_cast<int>(std::floor(direction.x * kCentre + 0.5));
  p.y = static_cast<int>(std::floor(direction.y * kCentre + 0.5));
  p.z = kCentre - std::abs(p.x) - std::abs(p.y);
  if (p.z < 0) {  // z is negative if x and y were both rounded away from zero
    p.y += p.y > 0 ? p.z : -p.z;
    p.z = 0;
  }
  if (direction.z < 0) p.z = -p.z;
  return p;
}

}  // namespace

bool hasDirection(glm::vec3 vector) noexcept {
  const double length = lengthOnOctahedron(vector);
  return std::isfinite(length) && length != 0;
}

uint16_t encodeOctahedral(glm::vec3 normal) noexcept {
  if (!hasDirection(normal)) return encodeOctahedral({0, 0, 1});
  const glm::ivec3 p = toIntegerOctahedron(glm::dvec3(normal) / lengthOnOctahedron(normal));
  glm::ivec2 square(p.y + kCentre, p.z + kCentre);
  if (p.x < 0) {  // the half with x < 0 is folded outwards to the square's corners
    square.x = p.y < 0 ? std::abs(p.z) : kLast - std::abs(p.z);
    square.y = p.z < 0 ? std::abs(p.y) : kLast - std::abs(p.y);
  }
  square = canonical(square);
  return static_cast<uint16_t>(square.x | square.y << 8);
}

glm::vec3 decodeOctahedral(uint16_t code) noexcept {
  const int u = (code & 255) - kCentre, v = (code >> 8) - kCentre;
  const int x = kCentre - std::abs(u) - std::abs(v);
  const int fold = x < 0 ? -x : 0;
  const int y = u < 0 ? u + fold : u - fold;
  const int z = v < 0 ? v + fold : v - fold;
  return glm::vec3(glm::normalize(glm::dvec3(x, y, z)));
}

}  // namespace lode
