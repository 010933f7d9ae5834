#include "client/app/window/camera/lost_sight.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

const core::ModelBox kModel{{-1, -1, -1}, {1, 1, 1}};

core::View from(glm::dvec3 eye_model) {
  core::View view;
  view.eye_model = eye_model;
  return view;
}

TEST(LostSight, isNotToldWhereTheModelIsSeen) {
  EXPECT_EQ(lostSightText(kModel, from({0, 0, 5})), "");
  EXPECT_EQ(lostSightText(kModel, from({0, 0, 0})), "") << "from inside";
}

TEST(LostSight, isToldOfAModelBesideOrBehindTheEye) {
  for (const glm::dvec3 eye_model : {glm::dvec3(0, 0, -5), glm::dvec3(50, 0, 5)})
    EXPECT_NE(lostSightText(kModel, from(eye_model)).find("out of the picture"), std::string_view::npos);
}

TEST(LostSight, isToldOfAModelOfAFewPixels) {
  EXPECT_NE(lostSightText(kModel, from({0, 0, 1e4})).find("a dot"), std::string_view::npos);
}

}  // namespace
}  // namespace lode::app
