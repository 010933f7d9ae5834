#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/core/lod/cut_probe.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// A surface point that the user has picked in the picture. Lengths are in the units of the scene's file.
struct PickedPoint {
  glm::dvec3 position_model;  ///< position in the frame of ViewedScene::summary()
  glm::dvec3 position;        ///< position in the coordinates of the model's or the scene's file
  bool is_ground = false;     ///< the point is on the scene's ground, which has no node, LOD or error
  bool is_on_cut = false;     ///< the point lies on a cut face of the section; it has no node, LOD or error
  NodeKey node;
  uint32_t lod = 0;
  float error_px = 0;
  double step = 1;  ///< lattice step, which limits the precision of the position
  std::optional<glm::u8vec3> colour;
  std::string model;  ///< name of the model; empty on the ground and in a scene of one model
  double error = 0;   ///< bound of the distance from the position to the original surface
  size_t model_number = 0, instance = 0;  ///< index in Scene::models, and of the model's instance
  core::Ray seen_along;                   ///< ray of the click, in the frame of position_model
  glm::dvec3 normal{0};                   ///< normal of the picked triangle in this frame, unit length
};

/// Returns the picked point of a ray's hit. @param textured  cut that has the model's textures; see
/// paintAt().
PickedPoint pointOf(const core::Hit& hit, const ModelSummary& model, const core::Cut& textured);

/// Returns a bound of the distance from a pick to the original surface: the point's error, plus half of the
/// diagonal of a lattice cell. Pure.
double uncertaintyOf(const PickedPoint& point) noexcept;
/// Returns the number of decimals that resolves a lattice step. More decimals would be meaningless. Pure.
int decimalsOf(double step) noexcept;

}  // namespace lode::app
