// Tests that build time stays below quadratic if very many triangles meet at one vertex, edge or position.

#include "tests/support/degenerate_shapes.h"

#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "server/ingest/pipeline/build.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kTriangles = 16000, kSmall = 200;
/// Largest allowed ratio of build times. A quadratic step would reach a ratio of up to 80.
constexpr double kMostTimesSmall = 6;

struct NamedShape {
  const char* name;
  std::function<test::Shape(uint32_t)> make;
};

/// Builds one shape per test.
class DegenerateShape : public testing::TestWithParam<NamedShape> {
 protected:
  /// Builds a store beside the model. @return CPU seconds.
  double build(const test::Shape& shape) const {
    test::writePly(shape, model_);
    BuildOptions options;
    options.input = model_;
    options.output = store_;
    options.threads = 1;
    return ingest::build(options).cpu_seconds;
  }

  test::WorkFolder folder_;
  const std::string model_ = folder_ / "a.ply", store_ = folder_ / "a.lode";
};

TEST_P(DegenerateShape, takesTimeInProportionToItsTriangles) {
  const double small = build(test::makeRow(GetParam().make, kTriangles / kSmall, kTriangles));
  EXPECT_LT(build(GetParam().make(kTriangles)), kMostTimesSmall * small);
}

const NamedShape kShapes[] = {
    {"hub", [](uint32_t n) { return test::makeHub(n); }},
    {"wavyHub", [](uint32_t n) { return test::makeHub(n, 31, 0.5f); }},
    {"needle", [](uint32_t n) { return test::makeHub(n, 0, 30); }},
    {"book", test::makeBook},
    {"star", test::makeStar},
    {"stack", [](uint32_t n) { return test::makeStack(n, false); }},
    {"stackOfBothSides", [](uint32_t n) { return test::makeStack(n, true); }},
    {"comb", test::makeComb},
    {"polarSphere", test::makePolarSphere},
};
INSTANTIATE_TEST_SUITE_P(Kinds, DegenerateShape, testing::ValuesIn(kShapes),
                         [](const auto& shape) { return std::string(shape.param.name); });

}  // namespace
}  // namespace lode::ingest
