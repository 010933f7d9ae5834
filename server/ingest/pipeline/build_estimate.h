#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace lode::ingest {

/// Progress of a whole build.
struct BuildStatus {
  std::string_view doing;              ///< current stage in a user's words; empty before the first stage
  double fraction = 0;                 ///< finished part of the build, 0 to 1
  std::optional<double> seconds_left;  ///< empty while unknown
  double done = 0, total = 0;          ///< items of the current stage; 0: unknown
  std::string_view unit;               ///< name of these items
  double items_per_s = 0;              ///< rate of the current stage; 0: unknown
};

/// Estimates the progress of a whole build from the progress of its stages. The estimate starts from the
/// usual shares of the stages. Finished stages correct the estimate of later ones. The current stage's own
/// rate gains weight as the stage advances. Pure: no clock.
class BuildEstimate {
 public:
  static constexpr size_t kStages = 8;

  /// @param threads  number of threads of the build, at least 1.
  explicit BuildEstimate(unsigned threads);

  /// Reports progress as BuildProgress does. Ignores unknown stages. A build whose first stage is not the
  /// scan counts as resumed.
  /// @param seconds  time since the build began, which never falls.
  void update(std::string_view stage, double fraction, uint64_t done, uint64_t total, double seconds);
  /// Returns the progress. Its fraction never falls.
  BuildStatus status() const;

 private:
  struct State {
    double cost = 0;  ///< forecast of the stage's time, in an arbitrary unit
    double spent_s = 0;
    bool is_finished = false;
  };

  void begin(size_t stage, double fraction);
  void countItems(uint64_t done, uint64_t total);
  std::optional<double> secondsPerCost() const;
  std::optional<double> secondsLeft() const;

  std::array<State, kStages> states_;
  size_t current_ = kStages;  ///< kStages: no stage has begun
  double begin_fraction_ = 0, fraction_ = 0;
  double loaded_cost_ = 0;  ///< cost of the work that a resumed build does not repeat
  double seconds_ = 0, reached_ = 0;
  double done_ = 0, total_ = 0;
  double triangles_ = 0;  ///< 0: unknown
};

}  // namespace lode::ingest
