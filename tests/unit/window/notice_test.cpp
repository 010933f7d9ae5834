#include "client/app/window/panel/notice.h"

#include <memory>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

stream::StreamStatus statusOf(bool converged) {
  auto cut = std::make_shared<core::Cut>();
  cut->converged = converged;
  stream::StreamStatus status;
  status.cut = cut;
  status.settled = true;
  return status;
}

TEST(Notice, isEmptyWithoutTrouble) {
  EXPECT_EQ(noticeOf(statusOf(true), false, OnGpu::kAll), Notice());
  EXPECT_EQ(noticeOf({}, false, OnGpu::kAll), Notice());
}

TEST(Notice, explainsALostConnectionAndItsReconnect) {
  stream::StreamStatus status = statusOf(false);
  status.trouble = "10.0.0.1:7400 closed the connection";
  const Notice notice = noticeOf(status, false, OnGpu::kAll);
  EXPECT_EQ(notice.kind, Notice::Kind::kTrouble);
  EXPECT_NE(notice.text.find(status.trouble), std::string::npos);
  EXPECT_NE(notice.text.find("reconnects automatically"), std::string::npos);
  status.trouble_remedy = Remedy::kModel;
  EXPECT_NE(noticeOf(status, false, OnGpu::kAll).text.find("; lodestream list shows what it has\n"),
            std::string::npos);
}

TEST(Notice, explainsThatThePictureStaysAfterTheStreamEnded) {
  stream::StreamStatus status = statusOf(true);
  status.failure = "no such model";
  status.trouble = "closed";
  status.ended = true;
  const Notice with_picture = noticeOf(status, false, OnGpu::kFull);
  EXPECT_EQ(with_picture.kind, Notice::Kind::kFailure);
  EXPECT_NE(with_picture.text.find("no such model"), std::string::npos);
  EXPECT_NE(with_picture.text.find("keeps what is loaded"), std::string::npos);
  status.cut.reset();
  EXPECT_EQ(noticeOf(status, false, OnGpu::kFull).text, "no such model");
  status.failure_remedy = Remedy::kModel;
  EXPECT_EQ(noticeOf(status, false, OnGpu::kFull).text, "no such model; lodestream list shows what it has");
}

TEST(Notice, explainsAnUnavailablePart) {
  stream::StreamStatus status = statusOf(true);
  status.failure = "blob 7 is damaged";
  EXPECT_EQ(noticeOf(status, false, OnGpu::kAll).text, "blob 7 is damaged\nThat part stays at lower detail.");
}

TEST(Notice, explainsThatAnUnreadablePartIsRetried) {
  stream::StreamStatus status = statusOf(true);
  status.failure = "blob 7 cannot be read now";
  status.failure_may_pass = true;
  EXPECT_EQ(noticeOf(status, false, OnGpu::kAll).kind, Notice::Kind::kTrouble);
  EXPECT_EQ(noticeOf(status, false, OnGpu::kAll).text,
            "blob 7 cannot be read now\nThat part stays at lower detail meanwhile; the view tries again.");
  status.cut.reset();
  EXPECT_EQ(noticeOf(status, false, OnGpu::kAll).text, "blob 7 cannot be read now\nThe view tries again.");
}

TEST(Notice, namesTheOptionThatGivesMoreMemory) {
  stream::StreamStatus status = statusOf(true);
  EXPECT_NE(noticeOf(status, false, OnGpu::kFull).text.find("--memory-budget"), std::string::npos);
  status.limited = true;
  EXPECT_NE(noticeOf(status, false, OnGpu::kAll).text.find("--memory-budget"), std::string::npos);
  status.settled = false;
  EXPECT_EQ(noticeOf(status, false, OnGpu::kAll), Notice()) << "it may still become finer";
  status.settled = true;
  EXPECT_EQ(noticeOf(status, false, OnGpu::kNotYetAll), Notice()) << "the last of it is still to be seen";
}

TEST(Notice, saysCalmlyThatTheCacheHasNoMoreAndHowToHaveTheRest) {
  stream::StreamStatus status = statusOf(false);
  status.settled = false;
  status.exhausted = true;
  status.failure = "the cache does not have all that the view needs: run without --offline";
  const Notice notice = noticeOf(status, true, OnGpu::kAll);
  EXPECT_EQ(notice.kind, Notice::Kind::kTrouble);
  EXPECT_NE(notice.text.find("no finer detail"), std::string::npos);
  EXPECT_NE(notice.text.find("without --offline"), std::string::npos);
  status.cut.reset();
  EXPECT_EQ(noticeOf(status, true, OnGpu::kAll).kind, Notice::Kind::kFailure) << "there is nothing to see";
}

TEST(Notice, showsOfflineAsAHintOnlyIfTheCacheIsComplete) {
  EXPECT_EQ(noticeOf(statusOf(true), true, OnGpu::kAll).kind, Notice::Kind::kHint);
  const Notice lacking = noticeOf(statusOf(false), true, OnGpu::kAll);
  EXPECT_EQ(lacking.kind, Notice::Kind::kTrouble);
  EXPECT_NE(lacking.text.find("without --offline"), std::string::npos);
}

TEST(Notice, saysTheFirstWarningOnOneLineWithTheKeyThatShowsAll) {
  EXPECT_EQ(warningOf({}, true), "");
  const std::vector<std::string> warnings{"3 faces dropped", "no normals", "no colours"};
  EXPECT_EQ(warningOf(std::span(warnings).first(1), false), "1 build warning (M: show all): 3 faces dropped");
  EXPECT_EQ(warningOf(warnings, false), "3 build warnings (M: show all): 3 faces dropped");
  EXPECT_EQ(warningOf(warnings, true),
            "3 build warnings (M: show less):\n3 faces dropped\nno normals\nno colours");
}

TEST(Notice, saysTheFirstMissingModelOnOneLineWithTheKeyThatShowsAll) {
  EXPECT_EQ(missingText({}, false), "");
  const std::vector<std::string> missing{"rock is missing: a.ply: no such file", "tree is missing"};
  EXPECT_EQ(missingText(std::span(missing).first(1), false),
            "1 missing model (M: show all): rock is missing: a.ply: no such file");
  EXPECT_EQ(missingText(missing, true),
            "2 missing models (M: show less):\nrock is missing: a.ply: no such file\ntree is missing");
}

TEST(Notice, namesTheHiddenModels) {
  EXPECT_EQ(hiddenText({}), "");
  EXPECT_EQ(hiddenText(std::vector<std::string>{"rock", "tree"}), "hidden: rock, tree");
}

TEST(Notice, explainsAFailedOpenAndHowToCloseTheWindow) {
  const Notice notice = noticeOf(Error(ErrorCode::kInput, "a.lode is damaged: build it again"));
  EXPECT_EQ(notice.kind, Notice::Kind::kFailure);
  EXPECT_EQ(notice.text, "a.lode is damaged: build it again\nEsc or Q closes the window.");
}

const core::ModelBox kModel{{-1, -1, -1}, {1, 1, 1}};

core::View from(glm::dvec3 eye_model) {
  core::View view;
  view.eye_model = eye_model;
  return view;
}

TEST(LostSight, isNotReportedIfTheModelIsVisible) {
  EXPECT_EQ(lostSightText(kModel, from({0, 0, 5})), "");
  EXPECT_EQ(lostSightText(kModel, from({0, 0, 0})), "") << "from inside";
}

TEST(LostSight, isReportedIfTheModelIsBesideOrBehindTheEye) {
  for (const glm::dvec3 eye_model : {glm::dvec3(0, 0, -5), glm::dvec3(50, 0, 5)})
    EXPECT_NE(lostSightText(kModel, from(eye_model)).find("out of view"), std::string_view::npos);
}

TEST(LostSight, isReportedIfTheModelCoversOnlyAFewPixels) {
  EXPECT_NE(lostSightText(kModel, from({0, 0, 1e4})).find("a dot"), std::string_view::npos);
}

}  // namespace

}  // namespace lode::app
