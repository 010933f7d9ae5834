#pragma once

namespace lode::app {

/// How far a picture has come from the error that it began with to the one that is wanted; each halving of
/// the error is a step of the same length. Pure.
class RefiningProgress {
 public:
  /// @param error_px, threshold_px  of the cut that is shown, > 0.
  /// @param converged  nothing more comes for this view.
  /// @return 0 to 1; 1 only if converged.
  double see(float error_px, float threshold_px, bool converged) noexcept;

 private:
  float start_px_ = 0;  ///< largest error since it had last converged
};

}  // namespace lode::app
