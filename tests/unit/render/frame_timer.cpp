#include "client/render/frame_timer.h"

#include "gl_fixture.h"

namespace lode::test {
namespace {

class FrameTimer : public GlTest {
 protected:
  static constexpr int kMostUnderWay = 4;

  static void frame(render::FrameTimer& timer, int number) {
    timer.begin();
    glClear(GL_COLOR_BUFFER_BIT);
    timer.end(10.0 * number, render::Coarsening{1.0 * number, 2.0 * number});
  }
};

TEST_F(FrameTimer, reportsNothingBeforeAFrame) {
  render::FrameTimer timer;
  EXPECT_FALSE(timer.take());
}

TEST_F(FrameTimer, reportsEachFrameOnceWithItsData) {
  render::FrameTimer timer;
  for (int number = 1; number < 20; ++number) {
    frame(timer, number);
    glFinish();
    const auto timed = timer.take();
    ASSERT_TRUE(timed);
    EXPECT_EQ(timed->coarsening->drawn, number);
    EXPECT_EQ(timed->cpu_ms, 10.0 * number);
    EXPECT_GE(timed->gpu_ms, 0);
    EXPECT_FALSE(timer.take());
  }
}

TEST_F(FrameTimer, reportsTheNumberOfAFrame) {
  render::FrameTimer timer;
  frame(timer, 1);  // pending while the next begins
  const std::optional<uint64_t> number = timer.begin();
  timer.end(20, std::nullopt);
  timer.wait();
  ASSERT_TRUE(timer.take());
  EXPECT_EQ(timer.take()->number, number);
}

TEST_F(FrameTimer, numbersNoFrameThatIsNotTimed) {
  render::FrameTimer timer;
  for (int number = 1; number <= kMostUnderWay; ++number) frame(timer, number);
  EXPECT_FALSE(timer.begin());
}

TEST_F(FrameTimer, skipsFramesWhileTooManyAreInFlight) {
  render::FrameTimer timer;
  for (int number = 1; number <= kMostUnderWay + 3; ++number) frame(timer, number);
  glFinish();
  for (int number = 1; number <= kMostUnderWay; ++number) {
    const auto timed = timer.take();
    ASSERT_TRUE(timed);
    EXPECT_EQ(timed->coarsening->drawn, number);
  }
  EXPECT_FALSE(timer.take());
  frame(timer, 99);
  glFinish();
  EXPECT_EQ(timer.take()->coarsening->drawn, 99);
}

}  // namespace
}  // namespace lode::test
