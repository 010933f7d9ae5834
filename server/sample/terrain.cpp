#include "server/sample/terrain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "server/sample/relief.h"

namespace lode::ingest {
namespace {

/// A number with its derivatives with respect to the two parameters of a surface. Arithmetic with these
/// numbers gives exact tangents. Source: forward-mode automatic differentiation.
struct Dual {
  double value = 0;
  glm::dvec2 slope{0};

  constexpr Dual(double constant = 0) : value(constant) {}  // NOLINT(google-explicit-constructor): a constant
  constexpr Dual(double v, const glm::dvec2& s) : value(v), slope(s) {}

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.slope + b.slope}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.slope - b.slope}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.slope + b.value * a.slope};
  }
};

/// Applies a function to a number. The caller passes the function's value and derivative at `at`.
Dual apply(const Dual& at, double value, double derivative) { return {value, derivative * at.slope}; }

Dual abs(const Dual& a) { return a.value < 0 ? Dual(0) - a : a; }

/// Returns a value that rises smoothly from 0 at `from` to 1 at `to` and is constant outside.
Dual smoothStep(double from, double to, const Dual& a) {
  const double t = (a.value - from) / (to - from);
  if (t <= 0) return 0;
  if (t >= 1) return 1;
  return apply(a, t * t * (3 - 2 * t), 6 * t * (1 - t) / (to - from));
}

/// Returns the maximum of two numbers, smoothed if they differ by less than `radius`.
Dual smoothMax(const Dual& a, const Dual& b, double radius) {
  const double gap = radius - std::abs(a.value - b.value);
  const Dual& larger = a.value > b.value ? a : b;
  if (gap <= 0) return larger;
  const Dual overlap = Dual(radius) - abs(a - b);
  return larger + overlap * overlap * Dual(1 / (4 * radius));
}

constexpr double kLakeLevel = 0.02;
constexpr double kSnowLevel = 0.46;
constexpr double kTerrace = 0.11;  // height of one terrace
constexpr size_t kMaxOctaves = 24;

using DualPoint = std::array<Dual, 3>;

/// Computes noise at points that depend on the surface's parameters.
class Field {
 public:
  template <class Random>
  Field(Random& random, double frequency) : frequency_(frequency) {
    const auto offset = [&] { return static_cast<double>(random() >> 40) * 0x1p-16; };
    const double x = offset(), y = offset(), z = offset();
    offset_ = {x, y, z};
    seed_ = static_cast<uint32_t>(random());
  }

  Dual at(const Dual& x, const Dual& y, const Dual& z = 0) const {
    const NoiseSample s = noise<true>(frequency_ * glm::dvec3(x.value, y.value, z.value) + offset_, seed_);
    return {s.value, frequency_ * (static_cast<double>(s.x) * x.slope + static_cast<double>(s.y) * y.slope +
                                   static_cast<double>(s.z) * z.slope)};
  }

 private:
  double frequency_;
  glm::dvec3 offset_{0};
  uint32_t seed_ = 0;
};

/// Shape of the land. Maps each point of the square from (-1, -1) to (1, 1) to a point in space.
class Land {
 public:
  /// @param finest  shortest wavelength; octaves near this wavelength are weakened.
  Land(uint64_t seed, double finest)
      : random_(seed),
        range_(random_, 0.9),
        rock_(random_, 1.7),
        strata_x_(random_, 1),
        strata_y_(random_, 1) {
    double frequency = 1.9;
    for (size_t i = 0; i < kMaxOctaves && frequency * finest < 1; ++i, frequency *= 2.07) {
      octaves_.push_back({Field(random_, frequency), std::fmin(1, 2 * (1 - frequency * finest))});
    }
  }

  DualPoint at(const glm::dvec2& parameters) const {
    const Dual u(parameters.x, {1, 0}), v(parameters.y, {0, 1});
    const Dual range = range_.at(u, v);
    const Dual alpine = smoothStep(-0.3, 0.25, range);
    Dual height = Dual(0.17) + Dual(0.26) * range + (Dual(0.08) + Dual(0.42) * alpine) * ridges(u, v);
    const Dual mesa = smoothStep(-0.02, 0.12, rock_.at(u, v));
    height = height + mesa * (terraced(height) - height);
    height = smoothMax(height, kLakeLevel, 0.004);
    return overhanging({u, v, height});
  }

 private:
  struct Octave {
    Field field;
    double share;  ///< weight of the octave; less than 1 near the shortest wavelength
  };

  /// Computes ridges with sharp crests and round valleys. High land is rougher than low land. Source:
  /// Musgrave's ridged multifractal, in Ebert et al., Texturing and Modeling, 2003.
  Dual ridges(const Dual& u, const Dual& v) const {
    Dual sum = 0, weight = 1;
    double amplitude = 1;
    for (const Octave& octave : octaves_) {
      const Dual crest = Dual(1) - abs(octave.field.at(u, v));
      const Dual signal = crest * crest * weight;
      sum = sum + Dual(amplitude * octave.share) * (signal - Dual(0.5) * weight);
      weight = smoothStep(0, 1, Dual(1.1) * signal);
      amplitude *= 0.47;
    }
    return sum;
  }

  /// Cuts a height into level treads and steep risers.
  static Dual terraced(const Dual& height) {
    const Dual steps = Dual(1 / kTerrace) * height;
    const double floor = std::floor(steps.value);
    const Dual within = steps - Dual(floor);
    const Dual riser = smoothStep(0.35, 0.65, within);
    return Dual(kTerrace) * (Dual(floor) + Dual(0.85) * riser + Dual(0.15) * within);
  }

  /// Shears space along x by (y, z) and along y by (x, z), so that hard strata overhang soft ones. Shears are
  /// injective, so the surface does not intersect itself.
  DualPoint overhanging(DualPoint p) const {
    const Dual firm = smoothStep(kLakeLevel, kLakeLevel + 0.06, p[2]);
    p[0] = p[0] + Dual(0.03) * firm * strata_x_.at(Dual(2) * p[1], Dual(17) * p[2]);
    p[1] = p[1] + Dual(0.03) * firm * strata_y_.at(Dual(2) * p[0], Dual(19) * p[2]);
    return p;
  }

  std::mt19937_64 random_;
  Field range_, rock_, strata_x_, strata_y_;
  std::vector<Octave> octaves_;
};

class Terrain final : public SampleModel {
 public:
  Terrain(uint64_t columns, uint64_t rows, uint64_t seed, AttributeSet attributes)
      : SampleModel(attributes),
        columns_(columns),
        rows_(rows),
        land_(seed, 5.0 / static_cast<double>(rows)),
        shade_(paint_random_, 9),
        speckle_(paint_random_, 60) {}

  uint64_t vertices() const override { return (columns_ + 1) * (rows_ + 1); }
  uint64_t triangles() const override { return 2 * columns_ * rows_; }
  uint64_t blocks() const override { return RowRange::blocksOf(columns_ * rows_); }

  void addVertices(uint64_t block, std::vector<SampleVertex>& to) const override {
    const RowRange range = RowRange::ofBlock(block, blocks(), vertices());
    for (uint64_t i = range.first; i < range.end; ++i)
      to.push_back(vertex(i % (columns_ + 1), i / (columns_ + 1)));
  }

  void addTriangles(uint64_t block, std::vector<glm::u32vec3>& to) const override {
    const RowRange range = RowRange::ofBlock(block, blocks(), columns_ * rows_);
    for (uint64_t i = range.first; i < range.end; ++i) {
      const uint64_t column = i % columns_, row = i / columns_;
      const auto a = static_cast<uint32_t>(row * (columns_ + 1) + column), b = a + 1;
      const auto d = static_cast<uint32_t>(a + columns_ + 1), c = d + 1;
      if ((column + row) % 2 == 0) {  // alternate the diagonals, so that the mesh has no preferred direction
        to.emplace_back(a, b, c);
        to.emplace_back(a, c, d);
      } else {
        to.emplace_back(a, b, d);
        to.emplace_back(b, c, d);
      }
    }
  }

 private:
  SampleVertex vertex(uint64_t column, uint64_t row) const {
    const glm::dvec2 uv(static_cast<double>(column) / static_cast<double>(columns_),
                        static_cast<double>(row) / static_cast<double>(rows_));
    const DualPoint p = land_.at(2.0 * uv - 1.0);
    const auto tangent = [&](int i) { return glm::dvec3(p[0].slope[i], p[1].slope[i], p[2].slope[i]); };
    const glm::dvec3 normal = glm::normalize(glm::cross(tangent(0), tangent(1)));
    SampleVertex vertex;
    vertex.position = {p[0].value, p[1].value, p[2].value};
    vertex.normal = normal;
    if (wants(AttributeSet::kColour)) vertex.colour = paint(glm::dvec3(vertex.position), normal.z);
    vertex.uv = uv;
    return vertex;
  }

  /// Returns the colour of water, sand, grass, banded rock on steep land, or snow on high flat land.
  glm::u8vec3 paint(const glm::dvec3& at, double flatness) const {
    const double shade = shade_.at(at.x, at.y).value;
    const double speckle = speckle_.at(at.x, at.y, at.z).value;
    const auto step = [](double from, double to, double x) { return smoothStep(from, to, x).value; };
    const double height = at.z + 0.03 * shade;
    const double band = std::sin(150 * at.z + 3 * shade);
    const glm::dvec3 rock = glm::mix(glm::dvec3(112, 92, 78), glm::dvec3(168, 138, 108), 0.5 + 0.5 * band);
    glm::dvec3 ground = glm::mix(glm::dvec3(74, 104, 44), glm::dvec3(138, 136, 76), step(0.1, 0.4, height));
    ground = glm::mix(glm::dvec3(206, 188, 140), ground, step(kLakeLevel + 0.01, kLakeLevel + 0.05, height));
    ground = glm::mix(ground, glm::dvec3(242, 245, 250), step(kSnowLevel, kSnowLevel + 0.1, height));
    glm::dvec3 colour = glm::mix(rock, ground, step(0.55, 0.8, flatness + 0.08 * shade));
    colour *= 1 + 0.12 * shade + 0.14 * speckle;
    const glm::dvec3 water(38, 84, 120);
    colour = glm::mix(water, colour, step(kLakeLevel + 0.001, kLakeLevel + 0.004, at.z));
    return glm::u8vec3(glm::clamp(colour + 0.5, 0.0, 255.0));
  }

  uint64_t columns_, rows_;
  Land land_;
  std::mt19937_64 paint_random_{7};
  Field shade_, speckle_;
};

}  // namespace

std::unique_ptr<SampleModel> makeTerrain(uint64_t triangles, uint64_t seed, AttributeSet attributes) {
  uint64_t columns = 1;
  while (2 * (columns + 1) * (columns + 1) <= triangles) ++columns;
  const uint64_t rows = 2 * columns * (columns + 1) <= triangles ? columns + 1 : columns;
  return std::make_unique<Terrain>(columns, rows, seed, attributes);
}

}  // namespace lode::ingest
