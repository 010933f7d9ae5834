#include "client/app/cli/made_path.h"

#include <cmath>
#include <random>
#include <vector>

#include <glm/gtc/constants.hpp>

#include "client/core/view/framing.h"

namespace lode::app {
namespace {

constexpr unsigned kOrbitKeys = 16, kFlyKeys = 9, kWalkKeys = 31;
constexpr double kOrbitSeconds = 20, kFlySeconds = 20, kWalkSeconds = 60;
/// Largest random offset from the straight line of flight on each axis, relative to half the box's side.
constexpr double kFlySpread = 0.3;
/// Least distance from the target, relative to the distance of the default camera.
constexpr double kNearestWalk = 0.1;
/// Largest angular speeds around the target in radians per second: kWalkStep horizontally, kWalkTurn
/// vertically.
constexpr double kWalkStep = 0.5, kWalkTurn = 0.15;

/// Random numbers that are the same on every platform, unlike those from the standard library's
/// distributions.
class Dice {
 public:
  explicit Dice(uint64_t seed) : random_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  glm::dvec3 inBox(const glm::dvec3& half) {
    const double x = between(-half.x, half.x), y = between(-half.y, half.y);
    return {x, y, between(-half.z, half.z)};
  }

 private:
  std::mt19937_64 random_;
};

core::CameraPath orbit(const core::CameraKey& first, uint64_t seed) {
  core::CameraPath path;
  const glm::dvec3 arm = first.eye - first.target;
  const double begin =
      2 * glm::pi<double>() * std::fmod(static_cast<double>(seed) / glm::golden_ratio<double>(), 1);
  for (unsigned i = 0; i <= kOrbitKeys; ++i) {
    const double part = static_cast<double>(i) / kOrbitKeys, angle = begin + 2 * glm::pi<double>() * part;
    const glm::dvec3 turned(arm.x * std::cos(angle) + arm.z * std::sin(angle), arm.y,
                            arm.z * std::cos(angle) - arm.x * std::sin(angle));
    path.keys.push_back(
        {kOrbitSeconds * part, first.target + turned * (1 - part / 2), first.target, first.up});
  }
  return path;
}

core::CameraPath fly(const core::CameraKey& first, const glm::dvec3& half, Dice& dice) {
  const glm::dvec3 side = glm::normalize(dice.inBox(glm::dvec3(1)) + glm::dvec3(0, 0, 1e-9));
  const glm::dvec3 reach = side * glm::length(half);
  std::vector<glm::dvec3> places;
  for (unsigned i = 0; i <= kFlyKeys; ++i) {
    const double along = 2.0 * i / kFlyKeys - 1;
    places.push_back(first.target + along * reach + dice.inBox(kFlySpread * half));
  }
  core::CameraPath path;
  for (unsigned i = 0; i < kFlyKeys; ++i)
    path.keys.push_back({kFlySeconds * i / (kFlyKeys - 1), places[i], places[i + 1], first.up});
  return path;
}

core::CameraPath walk(const core::CameraKey& first, const glm::dvec3& half, Dice& dice) {
  const double farthest = glm::distance(first.eye, first.target);
  constexpr double kKeySeconds = kWalkSeconds / (kWalkKeys - 1);
  double around = dice.between(0, 2 * glm::pi<double>()), above = dice.between(-0.5, 0.8);
  core::CameraPath path;
  for (unsigned i = 0; i < kWalkKeys; ++i) {
    const glm::dvec3 target = first.target + dice.inBox(half / 2.0);
    const double away = farthest * dice.between(kNearestWalk, 1);
    const glm::dvec3 arm(std::sin(around) * std::cos(above), std::sin(above),
                         std::cos(around) * std::cos(above));
    path.keys.push_back({kKeySeconds * i, target + away * arm, target, first.up});
    around += kKeySeconds * dice.between(-kWalkStep, kWalkStep);
    above = glm::clamp(above + kKeySeconds * dice.between(-kWalkTurn, kWalkTurn), -1.0, 1.0);
  }
  return path;
}

}  // namespace

core::CameraPath makePath(MadePath kind, const ModelSummary& model, uint64_t seed) {
  Dice dice(seed);
  const core::CameraPath framing = core::framingCamera(model);
  core::CameraKey first = framing.keys.front();
  if (!model.box.empty())  // aim at the box's centre, because the default camera looks slightly past it
    first.target = (model.lattice.toWorld(model.box.min) + model.lattice.toWorld(model.box.max)) / 2.0;
  const glm::dvec3 half = model.box.empty()
                              ? glm::dvec3(1)
                              : model.lattice.step * glm::dvec3(model.box.max - model.box.min) / 2.0;
  core::CameraPath path = kind == MadePath::kOrbit ? orbit(first, seed)
                          : kind == MadePath::kFly ? fly(first, half, dice)
                                                   : walk(first, half, dice);
  path.fov_y_deg = framing.fov_y_deg;
  return path;
}

}  // namespace lode::app
