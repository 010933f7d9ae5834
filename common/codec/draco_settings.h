#pragma once

#include "common/mesh.h"

/// What both halves of the Draco codec must agree on; nothing outside of them includes this.
namespace lode::draco_settings {

constexpr int kNormalBits = 8;
constexpr int kTextureBits = 16;

}  // namespace lode::draco_settings
