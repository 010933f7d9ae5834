#include "server/serve/memory/memory_budget.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"
#include "tests/unit/serve/session_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

TEST(MemoryBudget, isNeverExceededAndFullyReturned) {
  MemoryBudget budget(1 << 20);
  {
    std::vector<std::unique_ptr<MemoryAccount>> accounts;
    for (int i = 0; i < 1000; ++i) {
      accounts.push_back(std::make_unique<MemoryAccount>(budget));
      while (accounts.back()->tryTake(1000)) {
      }
      ASSERT_LE(budget.used(), budget.limit());
    }
  }
  EXPECT_EQ(budget.used(), 0u);
}

TEST(MemoryBudget, aPoliteConnectionHasRoomHoweverManyAreGreedy) {
  MemoryBudget budget(64 << 20);
  std::vector<std::unique_ptr<MemoryAccount>> greedy;
  for (int i = 0; i < 200; ++i) {
    greedy.push_back(std::make_unique<MemoryAccount>(budget));
    while (greedy.back()->tryTake(4096)) {
    }
  }
  for (int i = 0; i < 50; ++i) {
    greedy.push_back(std::make_unique<MemoryAccount>(budget));
    EXPECT_TRUE(greedy.back()->tryTake(kPoliteBytes)) << i;
  }
}

TEST(MemoryBudget, allowsEachConnectionLessTheMoreAreGreedy) {
  MemoryBudget budget(64 << 20);
  std::vector<std::unique_ptr<MemoryAccount>> greedy;
  for (int i = 0; i < 100; ++i) {
    greedy.push_back(std::make_unique<MemoryAccount>(budget));
    while (greedy.back()->tryTake(4096)) {
    }
  }
  EXPECT_LT(greedy.back()->held(), greedy.front()->held() / 2);
}

TEST(MemoryBudget, reservesAnEighthForAdmittedConnections) {
  MemoryBudget budget(1 << 20);
  std::vector<std::unique_ptr<MemoryAccount>> accounts;
  while (true) {
    accounts.push_back(std::make_unique<MemoryAccount>(budget));
    if (!accounts.back()->admit(8 << 10)) break;
  }
  EXPECT_LE(budget.used(), budget.limit() / 8 * 7);
  EXPECT_TRUE(accounts[0]->tryTake(32 << 10));
}

TEST(MemoryBudget, excludesOutgoingDataFromItsPressure) {
  MemoryBudget budget(1 << 20);
  MemoryAccount staying(budget);
  staying.take(100 << 10);
  {
    MemoryAccount leaving(budget);
    ASSERT_TRUE(leaving.admit(8 << 10));
    leaving.take(800 << 10);
    EXPECT_TRUE(budget.pressed());
    leaving.leave();
    EXPECT_FALSE(budget.pressed());
    EXPECT_TRUE(budget.relieved());
    EXPECT_FALSE(leaving.tryTake(1));
    leaving.give(100 << 10);
    leaving.take(10 << 10);
    staying.take(760 << 10);
    EXPECT_TRUE(budget.pressed());
    staying.give(760 << 10);
  }
  EXPECT_EQ(budget.used(), staying.held());
  staying.take(700 << 10);
  EXPECT_FALSE(budget.relieved());
}

TEST(MemoryBudget, defaultsToAnEighthOfTheMemoryHighOfAServiceUnit) {
  const lode::test::WorkFolder root;
  const auto group = root.path() / "sys/fs/cgroup/system.slice/lodestreamd.service";
  std::filesystem::create_directories(root.path() / "proc/self");
  std::filesystem::create_directories(group);
  std::ofstream(root.path() / "proc/self/cgroup") << "0::/system.slice/lodestreamd.service\n";
  std::ofstream(group / "memory.max") << "max\n";
  std::ofstream(group / "memory.high") << "400000000\n";
  EXPECT_EQ(defaultMemoryBudget(root.path()), 50'000'000u);
}

using SessionMemoryTest = SessionTest;

TEST_F(SessionMemoryTest, chargesAndReturnsRequestsAndAnswers) {
  open();
  const uint64_t before = memory_.held();
  request(RequestClass::kVisible, 1, 30, 1);
  EXPECT_EQ(memory_.held(), before + kRequestBytes);
  change(RequestAction::kCancel, RequestClass::kVisible, 1);
  const size_t answered = session_.controlBytes();
  EXPECT_EQ(memory_.held(), before + answered);
  session_.takeControl();
  session_.controlSent(answered);
  EXPECT_EQ(memory_.held(), before);
}

TEST_F(SessionMemoryTest, anOpenModelIsChargedUntilItIsClosed) {
  send(proto::Hello{});
  const uint64_t before = memory_.held() - session_.controlBytes();
  send(proto::Open{"a", {}});
  EXPECT_EQ(memory_.held(), before + session_.controlBytes() + kOpenModelBytes);
  send(proto::Close{1});
  EXPECT_EQ(memory_.held(), before + session_.controlBytes());
  {
    MemoryAccount memory(budget_);
    Session session({&served_, &memory}, limits_, now_);
    sendTo(session, proto::Hello{});
    sendTo(session, proto::Open{"a", {}});
    EXPECT_GT(memory.held(), kOpenModelBytes);
  }
  EXPECT_EQ(budget_.used(), memory_.held());
}

TEST_F(SessionMemoryTest, closingAModelGivesItsRequestsBack) {
  open();
  const uint64_t before = memory_.held();
  for (uint32_t i = 1; i <= 10; ++i) request(RequestClass::kVisible, i, 30, 1);
  send(proto::Close{1});
  EXPECT_EQ(memory_.held() + kOpenModelBytes, before + session_.controlBytes());
}

TEST_F(SessionMemoryTest, aRefusedSessionGivesItsRequestsBackBeforeItsLastWordIsOut) {
  open();
  session_.controlSent(memory_.held() - kOpenModelBytes);
  for (uint32_t i = 1; i <= 10; ++i) request(RequestClass::kVisible, i, 30, 1);
  EXPECT_EQ(memory_.held(), kOpenModelBytes + 10 * kRequestBytes);
  session_.refuse(WireError::kMalformed, "this is no frame");
  EXPECT_EQ(memory_.held(), kOpenModelBytes + session_.controlBytes());
}

TEST_F(SessionMemoryTest, opensNoModelWithoutMemory) {
  send(proto::Hello{});
  session_.takeControl();
  MemoryAccount others(budget_);
  others.take(budget_.limit() / 4 * 3);
  memory_.take(kPoliteBytes - 200 - memory_.held());
  send(proto::Open{"a", {}}, 7);
  const auto refused = only<proto::ErrorMessage>(FrameType::kError, 7);
  EXPECT_EQ(refused.code, WireError::kLimit);
  EXPECT_FALSE(refused.closes);
  EXPECT_FALSE(session_.closing());
}

TEST_F(SessionMemoryTest, refusesARequestWithoutMemoryAndContinues) {
  open();
  MemoryAccount others(budget_);
  others.take(budget_.limit() / 4 * 3);
  memory_.take(kPoliteBytes - 200 - memory_.held());
  request(RequestClass::kVisible, 1, 30, 1);
  request(RequestClass::kVisible, 2, 3, 1);
  const auto refused = only<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(refused.code, WireError::kNotReady);
  EXPECT_EQ(refused.request, 2u);
  EXPECT_EQ(session_.openRequests(), 1u);
  EXPECT_FALSE(session_.closing());
}

TEST_F(SessionMemoryTest, aGreedySessionIsRefusedWhereAPoliteOneIsServed) {
  limits_.max_open_requests = proto::kMaxOpenRequests;
  MemoryBudget budget(8u << 20);
  MemoryAccount greedy_memory(budget), polite_memory(budget);
  Session greedy({&served_, &greedy_memory}, limits_, now_),
      polite({&served_, &polite_memory}, limits_, now_);
  for (Session* session : {&greedy, &polite}) {
    sendTo(*session, proto::Hello{});
    sendTo(*session, proto::Open{"a", {}});
  }
  for (uint32_t frame = 0; frame < 4; ++frame) {
    proto::Requests requests{1, {}};
    for (uint32_t i = 1; i <= proto::kMaxRequestsPerFrame; ++i)
      requests.changes.push_back(
          {RequestAction::kAdd, RequestClass::kVisible, frame * proto::kMaxRequestsPerFrame + i, 30, 1});
    sendTo(greedy, requests);
  }
  EXPECT_TRUE(greedy.closing()) << greedy.openRequests();
  sendTo(polite, proto::Requests{1, {{RequestAction::kAdd, RequestClass::kVisible, 1, 30, 1}}});
  EXPECT_EQ(polite.openRequests(), 1u);
}

}  // namespace
}  // namespace lode::serve
