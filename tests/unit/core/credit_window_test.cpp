#include "client/core/session/credit_window.h"

#include <gtest/gtest.h>

#include "proto/limits.h"

namespace lode::core {
namespace {

using std::chrono::milliseconds;

/// A link that delivers the window in pieces, at a fixed rate.
class SteadyLink {
 public:
  SteadyLink(double bytes_per_s, milliseconds trip) : bytes_per_s_(bytes_per_s), trip_(trip) {
    window_.measureTrip(trip);
  }

  void run(milliseconds time) {
    for (const TimePoint end = now_ + time; now_ < end; now_ += milliseconds(1)) {
      const double allowed =
          static_cast<double>(window_.bytes()) / std::chrono::duration<double>(trip_).count();
      window_.receive(static_cast<uint64_t>(std::min(allowed, bytes_per_s_) * 1e-3), now_);
    }
  }

  void pause(milliseconds time) {
    window_.pause();
    now_ += time;
  }

  void slowDown(double bytes_per_s) { bytes_per_s_ = bytes_per_s; }

  /// Bandwidth-delay product.
  double windowRatio() const {
    return static_cast<double>(window_.bytes()) /
           (bytes_per_s_ * std::chrono::duration<double>(trip_).count());
  }
  const CreditWindow& window() const { return window_; }

 private:
  double bytes_per_s_;
  milliseconds trip_;
  TimePoint now_{};
  CreditWindow window_;
};

TEST(CreditWindow, startsWithTheInitialGrant) {
  EXPECT_EQ(CreditWindow().bytes(), proto::kInitialWindowBytes);
  EXPECT_EQ(CreditWindow().bytesPerSecond(), 0);
}

TEST(CreditWindow, isOneAndAHalfTimesTheCapacityOfASlowLink) {
  SteadyLink link(1.25e6, milliseconds(50));
  link.run(milliseconds(1000));
  EXPECT_NEAR(link.windowRatio(), 1.5, 0.1);
}

TEST(CreditWindow, growsWithinASecondToTheCapacityOfAFastLongLink) {
  SteadyLink link(25e6, milliseconds(100));
  link.run(milliseconds(1000));
  EXPECT_NEAR(link.windowRatio(), 1.5, 0.1);
}

TEST(CreditWindow, shrinksWhenTheLinkSlowsDown) {
  SteadyLink link(12.5e6, milliseconds(100));
  link.run(milliseconds(2000));
  link.slowDown(1.25e6);
  link.run(milliseconds(2000));
  EXPECT_NEAR(link.windowRatio(), 1.5, 0.1);
}

TEST(CreditWindow, isNotReducedByPauses) {
  SteadyLink link(12.5e6, milliseconds(100));
  link.run(milliseconds(2000));
  for (int time = 0; time < 20; ++time) {
    link.pause(milliseconds(500));
    link.run(milliseconds(60));
  }
  EXPECT_NEAR(link.windowRatio(), 1.5, 0.1);
}

TEST(CreditWindow, staysWithinItsLimitHoweverFastTheLink) {
  SteadyLink link(1e12, milliseconds(100));
  link.run(milliseconds(3000));
  EXPECT_EQ(link.window().bytes(), kMaxWindowBytes);
}

TEST(CreditWindow, goesByTheSmallestRoundTrip) {
  CreditWindow window;
  window.measureTrip(milliseconds(80));
  window.measureTrip(milliseconds(50));
  window.measureTrip(milliseconds(120));
  EXPECT_EQ(window.roundTrip(), milliseconds(50));
}

}  // namespace
}  // namespace lode::core
