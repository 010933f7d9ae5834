#include "server/ingest/soup/uv_grid.h"

#include <algorithm>
#include <cmath>

#include "common/codec/texture_set.h"
#include "common/error.h"

namespace lode::ingest {
namespace {

constexpr double kCodes = 65536;

double stepOf(int32_t exponent) { return std::ldexp(1.0, exponent - 16); }

}  // namespace

glm::u16vec2 UvGrid::snap(glm::vec2 uv) const noexcept {
  const glm::dvec2 codes = (glm::dvec2(uv) - origin) / stepOf(scale_exponent);
  return glm::u16vec2(glm::clamp(glm::floor(codes + 0.5), 0.0, kCodes - 1));
}

UvGrid chooseUvGrid(const UvRange& range, const std::string& file) {
  UvGrid grid;
  if (range.withinImage()) return grid;
  for (; grid.scale_exponent <= kMaxUvExponent; ++grid.scale_exponent) {
    const double step = stepOf(grid.scale_exponent);
    grid.origin = glm::floor(range.min / step) * step;
    if (glm::any(glm::greaterThan(glm::abs(grid.origin), glm::dvec2(kMaxUvOrigin)))) break;
    if (glm::all(glm::lessThanEqual((range.max - grid.origin) / step, glm::dvec2(kCodes)))) return grid;
  }
  throw Error(ErrorCode::kInput,
              file + ": texture coordinates range from " +
                  std::to_string(std::min(range.min.x, range.min.y)) + " to " +
                  std::to_string(std::max(range.max.x, range.max.y)) +
                  ", too far for a store; correct wrong coordinates or export the model without");
}

}  // namespace lode::ingest
