#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/render/gl/framebuffer.h"
#include "client/render/gl/offscreen_context.h"
#include "client/render/renderer.h"
#include "common/error.h"

namespace lode::test {

constexpr uint32_t kWidthPx = 200, kHeightPx = 150;

/// A test that draws. Skipped without an OpenGL 4.5 context.
class GlTest : public ::testing::Test {
 public:
  /// Magenta background: no shading of a grey model is magenta.
  static render::DrawStyle magentaBehind() {
    render::DrawStyle style;
    style.background_top_srgb = style.background_bottom_srgb = glm::vec3(1, 0, 1);
    return style;
  }

  static render::Image draw(render::Renderer& renderer, const core::View& view,
                            const render::DrawStyle& style = magentaBehind(), int samples = 4) {
    const render::Framebuffer target(view.width_px, view.height_px, samples);
    renderer.draw(view, target, style);
    target.resolve();
    return target.readPixels();
  }

  /// Uploads all meshes and draws them.
  static render::Image drawMeshes(const std::vector<Mesh>& meshes, double step, const core::View& view,
                                  const render::DrawStyle& style = magentaBehind()) {
    render::Renderer renderer(step);
    renderer.meshes().show(cutOf(meshes));
    renderer.meshes().uploadInRenderThread({.wait = true});
    EXPECT_TRUE(renderer.meshes().upToDate());
    return draw(renderer, view, style);
  }

  static std::shared_ptr<const core::Cut> cutOf(const std::vector<std::shared_ptr<const Mesh>>& meshes) {
    auto cut = std::make_shared<core::Cut>();
    for (uint32_t i = 0; i < meshes.size(); ++i) {
      cut->parts.push_back({NodeKey{8 + i}, 0, true, 0, meshes[i]});
      cut->triangles += meshes[i]->triangles.size();
    }
    return cut;
  }

  static std::shared_ptr<const core::Cut> cutOf(const std::vector<Mesh>& meshes) {
    std::vector<std::shared_ptr<const Mesh>> shared;
    for (const Mesh& mesh : meshes) shared.push_back(std::make_shared<const Mesh>(mesh));
    return cutOf(shared);
  }

 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<render::OffscreenContext>();
    } catch (const Error& error) {
      GTEST_SKIP() << "no OpenGL here: " << error.what();
    }
  }

 private:
  std::unique_ptr<render::OffscreenContext> context_;
};

inline core::View lookAt(glm::dvec3 eye, glm::dvec3 target, glm::dvec3 up = {0, 1, 0}) {
  core::View view;
  view.eye_model = eye;
  view.forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(view.forward, up));
  view.up = glm::cross(right, view.forward);
  view.width_px = kWidthPx;
  view.height_px = kHeightPx;
  return view;
}

/// True if at least one sample of the pixel shows the magenta background.
inline bool showsMagenta(const uint8_t* rgba) { return rgba[1] < 0.8 * rgba[0] && rgba[1] < 0.8 * rgba[2]; }

inline bool isMagenta(const uint8_t* rgba) { return rgba[0] == 255 && rgba[1] == 0 && rgba[2] == 255; }

/// A square facing a camera that looks along -z.
inline Mesh squareAt(uint32_t x, uint32_t y, uint32_t z, uint32_t side, glm::u8vec4 colour) {
  Mesh mesh;
  mesh.attributes.bits = AttributeSet::kColour;
  for (const auto& [dx, dy] : {std::pair{0u, 0u}, {side, 0u}, {side, side}, {0u, side}}) {
    mesh.positions.push_back(packPosition({x + dx, y + dy, z}));
    mesh.vertex_attributes.push_back({0, 0, colour, {}});
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

}  // namespace lode::test
