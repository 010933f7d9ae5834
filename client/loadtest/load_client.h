#pragma once

#include <exception>
#include <string>

#include "client/core/view/time_point.h"
#include "client/loadtest/load_counts.h"
#include "common/error.h"

namespace lode::app {

constexpr auto kNever = core::TimePoint::max();

/// One client of a load test. Lives on the thread that runs its context.
class LoadClient {
 public:
  virtual ~LoadClient() = default;

  /// When step() has something to do next; kNever once it has ended.
  virtual core::TimePoint due() const noexcept = 0;
  /// Connects, also anew, requests what is due, keeps the connection alive.
  virtual void step(core::TimePoint now) = 0;
  /// What is not there yet counts as late as it is.
  virtual void finish(core::TimePoint now) = 0;
};

/// What goes wrong with one client is counted and ends it; the others go on. @return false: it ends.
template <typename Action>
bool survives(LoadCounts& counts, const Action& action) {
  try {
    action();
    return true;
  } catch (const Error& error) {
    counts.noteError(error.code(), error.what());
  } catch (const std::exception& error) {
    counts.noteError(ErrorCode::kInternal, error.what());
  }
  ++counts.gave_up;
  return false;
}

/// A client that a server has turned away until the test's end is an error.
/// @param why  the last time; empty if none has.
inline void noteNeverLetIn(LoadCounts& counts, const std::string& why) {
  if (!why.empty()) counts.noteError(ErrorCode::kNetwork, "never let in: " + why);
}

}  // namespace lode::app
