#include "client/app/window/scene/measure.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/app/window/scene/picks.h"

namespace lode::app {
namespace {

const glm::dvec3 kZUp(0, 0, 1);

PickedPoint measuredPoint(glm::dvec3 position, double off = 0.01) {
  PickedPoint point;
  point.position = position;
  point.step = 1e-9;
  point.error = off;
  return point;
}

Measure measureOf(MeasureKind kind, const std::vector<glm::dvec3>& positions) {
  Measure measure{kind, {}};
  for (const glm::dvec3& position : positions) measure.points.push_back(measuredPoint(position));
  return measure;
}

const std::vector<glm::dvec3> kCorners{{1e6, 5, 7}, {1e6 + 3, 5, 7}, {1e6 + 3, 9, 7}, {1e6, 9, 9}};

std::vector<glm::dvec3> firstCorners(size_t count) {
  return {kCorners.begin(), kCorners.begin() + static_cast<ptrdiff_t>(count)};
}

TEST(Measures, haveTheirValues) {
  const auto value = [](MeasureKind kind, size_t count) {
    return valueOf(measureOf(kind, firstCorners(count)), kZUp)->value;
  };
  EXPECT_NEAR(value(MeasureKind::kDistance, 2), 3, 1e-9);
  EXPECT_NEAR(value(MeasureKind::kPolyline, 3), 7, 1e-9);
  EXPECT_NEAR(value(MeasureKind::kAngle, 3), 90, 1e-9);
  EXPECT_NEAR(value(MeasureKind::kArea, 3), 6, 1e-9);
  EXPECT_NEAR(valueOf(measureOf(MeasureKind::kHeight, {kCorners[2], kCorners[3]}), kZUp)->value, 2, 1e-9);
  EXPECT_NEAR(valueOf(measureOf(MeasureKind::kHeight, {kCorners[3], kCorners[2]}), kZUp)->value, -2, 1e-9);
}

TEST(Measures, haveNoValueWhilePointsAreMissing) {
  for (const MeasureKind kind : {MeasureKind::kDistance, MeasureKind::kPolyline, MeasureKind::kHeight})
    EXPECT_FALSE(valueOf(measureOf(kind, firstCorners(1)), kZUp));
  for (const MeasureKind kind : {MeasureKind::kAngle, MeasureKind::kArea})
    EXPECT_FALSE(valueOf(measureOf(kind, firstCorners(2)), kZUp));
}

TEST(Measures, areOffByNoMoreThanTheySayWherePointsAreOffByTheirErrors) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (size_t number = 0; number < kMeasureKindCount; ++number) {
    const auto kind = static_cast<MeasureKind>(number);
    const Measure measure = measureOf(kind, firstCorners(std::min<size_t>(mostPoints(kind), 4)));
    const MeasuredValue said = *valueOf(measure, kZUp);
    double most = 0;
    for (int i = 0; i < 3000; ++i) {
      Measure moved = measure;
      for (PickedPoint& point : moved.points)
        point.position +=
            glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))) * point.error;
      most = std::max(most, std::abs(valueOf(moved, kZUp)->value - said.value));
    }
    EXPECT_LE(most, said.off) << nameOf(kind);
    EXPECT_GT(most, said.off / 5) << nameOf(kind) << ": the bound is not idle";
  }
}

TEST(Measures, areTextsWithTheirUnit) {
  EXPECT_EQ(valueText(measureOf(MeasureKind::kDistance, firstCorners(2)), kZUp, "mm"),
            "3.000 \u00b1 0.020 mm");
  EXPECT_EQ(valueText(measureOf(MeasureKind::kArea, firstCorners(3)), kZUp, "m"),
            "6.000 \u00b1 0.060 m\u00b2");
  EXPECT_EQ(valueText(measureOf(MeasureKind::kAngle, firstCorners(3)), kZUp, "m"),
            "90.00 \u00b1 0.67 \u00b0");
  EXPECT_EQ(valueText(measureOf(MeasureKind::kAngle, firstCorners(2)), kZUp, "m"), "");
}

TEST(Measures, areKeptDroppedAndOfSeveralKinds) {
  Picks picks;
  EXPECT_FALSE(picks.keep());
  for (const glm::dvec3& corner : firstCorners(2)) picks.add(measuredPoint(corner));
  EXPECT_TRUE(picks.keep());
  EXPECT_TRUE(picks.current().points.empty());
  picks.nextKind();
  EXPECT_EQ(picks.kind(), MeasureKind::kPolyline);
  for (const glm::dvec3& corner : kCorners) picks.add(measuredPoint(corner));
  EXPECT_EQ(picks.current().points.size(), 4u);
  EXPECT_EQ(picks.all().size(), 2u);
  picks.nextKind();
  EXPECT_EQ(picks.current().points.size(), 3u) << "an angle has three points";
  picks.clear();
  EXPECT_EQ(picks.lines(kZUp, "m"), std::vector<std::string>{"distance 3.000 \u00b1 0.020 m"});
  EXPECT_TRUE(picks.dropLast());
  EXPECT_FALSE(picks.dropLast());
}

TEST(Measures, areTablesAndJson) {
  std::vector<Measure> measures{measureOf(MeasureKind::kDistance, firstCorners(2)),
                                measureOf(MeasureKind::kAngle, firstCorners(3)),
                                measureOf(MeasureKind::kArea, firstCorners(2))};
  measures[0].points[0].model = "ro\"ck\xff";
  const std::string csv = measuresAsCsv(measures, kZUp, "mm");
  EXPECT_EQ(csv.substr(0, csv.find("\nangle")),
            "kind,value,uncertainty,unit,points\ndistance,3,0.0200000017321,mm,1000000 5 7;1000003 5 7");
  EXPECT_EQ(std::ranges::count(csv, '\n'), 3) << "an area of two points has no value";
  const auto json = nlohmann::json::parse(measuresAsJson(measures, kZUp, "mm"));
  ASSERT_EQ(json["measurements"].size(), 2u);
  EXPECT_EQ(json["measurements"][0]["unit"], "mm");
  EXPECT_EQ(json["measurements"][0]["points"][1]["position"][0], 1e6 + 3);
  EXPECT_EQ(json["measurements"][1]["unit"], "deg");
  EXPECT_NEAR(json["measurements"][1]["value"].get<double>(), 90, 1e-9);
}

}  // namespace
}  // namespace lode::app
