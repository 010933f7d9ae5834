#include "client/app/window/scene/scene_status.h"

#include <memory>

#include <gtest/gtest.h>

#include "client/core/lod/cut.h"

namespace lode::app {
namespace {

core::View viewFrom(double x) {
  core::View view;
  view.eye_model = {x, 0, 0};
  return view;
}

/// Status of a model that has converged for a view.
stream::StreamStatus makeStatus(const core::View& view, uint64_t received_bytes) {
  stream::StreamStatus status;
  auto cut = std::make_shared<core::Cut>();
  cut->view = view;
  cut->converged = true;
  status.cut = std::move(cut);
  status.view_cuts = std::make_shared<core::ViewCuts>();
  status.settled = status.current = true;
  status.counts.received_bytes = received_bytes;
  return status;
}

class SceneStatus : public testing::Test {
 protected:
  stream::StreamStatus merged() const {
    return sceneStatus(std::vector<ModelStatus>{{first_, first_view_}, {second_, second_view_}}, scene_view_);
  }
  const core::View scene_view_ = viewFrom(9), first_view_ = viewFrom(1), second_view_ = viewFrom(2);
  stream::StreamStatus first_ = makeStatus(first_view_, 10), second_ = makeStatus(second_view_, 5);
};

TEST_F(SceneStatus, hasTheScenesViewOnceEachModelIsCurrent) {
  ASSERT_TRUE(merged().cut);
  EXPECT_EQ(merged().cut->view, scene_view_);
  second_ = makeStatus(first_view_, 5);
  EXPECT_NE(merged().cut->view, scene_view_);
}

TEST_F(SceneStatus, addsUpTheMissingTilesOfItsModels) {
  for (stream::StreamStatus* const status : {&first_, &second_}) {
    auto cut = std::make_shared<core::Cut>(*status->cut);
    cut->lost_tiles = 2;
    status->cut = std::move(cut);
  }
  EXPECT_EQ(merged().cut->lost_tiles, 4u);
}

TEST_F(SceneStatus, isCurrentOnceEachModelIs) {
  EXPECT_TRUE(merged().current);
  second_.current = false;
  EXPECT_FALSE(merged().current);
}

TEST_F(SceneStatus, hasConvergedAndSettledOnceEachModelHas) {
  EXPECT_TRUE(merged().cut->converged && merged().settled);
  second_.settled = false;
  EXPECT_FALSE(merged().settled);
}

TEST_F(SceneStatus, hasTheCoarsestThresholdOfItsModels) {
  const auto withThreshold = [](const core::View& view, float threshold_px) {
    stream::StreamStatus status = makeStatus(view, 0);
    auto cut = std::make_shared<core::Cut>(*status.cut);
    cut->threshold_px = threshold_px;
    status.cut = std::move(cut);
    return status;
  };
  first_ = withThreshold(first_view_, 0.25f);
  second_ = withThreshold(second_view_, 0.5f);
  EXPECT_EQ(merged().cut->threshold_px, 0.5f);
}

TEST_F(SceneStatus, hasNoCutBeforeEachModelHasOne) {
  second_.view_cuts = nullptr;
  EXPECT_FALSE(merged().cut);
}

TEST_F(SceneStatus, hasNotEndedWhileOneModelContinues) {
  first_.ended = true;
  first_.failure = "the server has gone";
  first_.failure_remedy = Remedy::kCertificate;
  EXPECT_FALSE(merged().ended);
  EXPECT_EQ(merged().failure, "the server has gone");
  EXPECT_EQ(merged().failure_remedy, Remedy::kCertificate);
  second_.ended = true;
  EXPECT_TRUE(merged().ended);
}

TEST_F(SceneStatus, hasTheRemedyOfTheTroubleThatItNames) {
  second_.trouble = "no such model";
  second_.trouble_remedy = Remedy::kModel;
  EXPECT_EQ(merged().trouble, "no such model");
  EXPECT_EQ(merged().trouble_remedy, Remedy::kModel);
}

TEST_F(SceneStatus, hasNotEndedBeforeThereIsAModel) { EXPECT_FALSE(sceneStatus({}, scene_view_).ended); }

TEST_F(SceneStatus, addsUpTheCountsOfItsModels) {
  first_.counts.round_trip_ms = 7;
  first_.counts.requests.visible = second_.counts.requests.visible = 2;
  EXPECT_EQ(merged().counts.received_bytes, 15u);
  EXPECT_EQ(merged().counts.requests.visible, 4u);
  EXPECT_EQ(merged().counts.round_trip_ms, 7);
}

}  // namespace
}  // namespace lode::app
