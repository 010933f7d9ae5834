#pragma once

namespace lode::render {

/// GLSL of AmbientOcclusion, for linkProgram(), in the order in which they run; depth is the picture's,
/// reversed and without a far plane: 1 at the near plane, 0 of the background, affine on what is flat.
extern const char* const kHalvingShader;
extern const char* const kOcclusionShader;
extern const char* const kOcclusionBlurShader;
extern const char* const kDarkeningShader;

/// Locations of their uniforms.
enum OcclusionUniform { kOcclusionMiddle, kOcclusionRayStep, kOcclusionReach };
enum BlurUniform { kBlurAlong };
enum DarkeningUniform { kDarkeningSamples };

}  // namespace lode::render
