#pragma once

#include <cstdint>
#include <string>

namespace lode::app {

/// A bound beyond it says nothing: the eye is in a part's box, and the part may be anywhere in it.
constexpr float kLargestToldErrorPx = 64;

/// How far a picture has come that becomes finer.
struct Refining {
  float error_px = 0, threshold_px = 1;
  uint64_t tiles_to_come = 0;  ///< of textures
  uint64_t received_bytes = 0;
};

/// For people, how far a picture may be off, or what it lacks: of one that becomes finer,
std::string refiningText(const Refining& refining);
/// of one that memory keeps from that,
std::string limitedText(float error_px);
/// of one whose server has gone away meanwhile,
std::string waitingText(float error_px);
/// of one that lacks what is damaged, or refused for good,
std::string lackingText(float error_px);
/// and of one that has converged. Above the threshold that is so only where the file has no more.
std::string convergedText(float error_px, float threshold_px);

}  // namespace lode::app
