#include "client/render/culling/gpu_culling.h"

#include <algorithm>

#include "client/core/lod/triangle_clusters.h"
#include "client/render/culling/cluster_culling.h"
#include "client/render/renderer.h"
#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using render::GpuCulling;
using render::SeenPart;

class GpuCullingTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!IsSkipped() && !GpuCulling::isPossible()) GTEST_SKIP() << "this driver does not count draws";
  }
  void TearDown() override { EXPECT_TRUE(IsSkipped() || glGetError() == GL_NO_ERROR); }

  static std::shared_ptr<const core::Cut> plainCut() {
    Mesh mesh = makeGrid(40, 40, {.attributes = {AttributeSet::kNormal}, .extent = 4000});
    core::clusterTriangles(mesh);
    return cutOf(std::vector{std::move(mesh)});
  }
  static core::View fromAbove() { return lookAt({2000, 2000, 9000}, {2000, 2000, 0}); }
  static std::vector<uint32_t> countsOf(const GpuCulling& culling, size_t lists) {
    std::vector<uint32_t> counts(lists);
    glGetNamedBufferSubData(culling.counts(), 4 * GLintptr{culling.firstCountOfPass()},
                            static_cast<GLsizeiptr>(4 * lists), counts.data());
    return counts;
  }
};

TEST_F(GpuCullingTest, cullsMorePlacementsThanADispatchHolds) {
  constexpr uint32_t kPlacements = 70'000;
  render::MeshResidency meshes({});
  meshes.show(plainCut());
  meshes.uploadInRenderThread({.wait = true});
  const SeenPart part{&meshes.drawn()[0], 0, false};
  GpuCulling culling;
  culling.begin();
  for (uint32_t i = 0; i < kPlacements; ++i) culling.add({&part, 1}, meshes.pages(), 1, fromAbove(), {});
  culling.findUnhidden();
  const std::vector<uint32_t> counts = countsOf(culling, kPlacements);
  EXPECT_EQ(std::ranges::count(counts, 1u), kPlacements);
  EXPECT_EQ(culling.draws(kPlacements - 1).size(), 1u);
}

/// Draws with GPU culling that may read pages of up to this size.
render::Image drawReading(uint64_t most_readable_bytes, const std::shared_ptr<const core::Cut>& cut,
                          const core::View& view) {
  render::Renderer renderer;
  renderer.show(cut);
  renderer.uploadInRenderThread({.wait = true});
  GpuCulling culling(most_readable_bytes);
  const render::Framebuffer target(view.width_px, view.height_px);
  for (int frame = 0; frame < 2; ++frame) {
    startPicture(target, {});
    culling.begin();
    renderer.addInstance(0, view, {}, {}, culling);
    culling.findUnhidden();
    renderer.drawFound(0, view, target, {}, culling);
    culling.findAppeared(target);
    render::continuePicture(target);
    renderer.drawFound(0, view, target, {}, culling);
    renderer.drawBackground(target, {});
  }
  target.resolve();
  return target.readPixels();
}

TEST_F(GpuCullingTest, drawsMeshesInAPageLargerThanTheShaderLimit) {
  render::Renderer renderer;
  renderer.show(plainCut());
  renderer.uploadInRenderThread({.wait = true});
  const core::View view = lookAt({200, 2000, 500}, {2000, 2000, 0}, {0, 0, 1});
  const render::Image picture = draw(renderer, view, {});
  EXPECT_EQ(drawReading(0, plainCut(), view).rgba, picture.rgba);
  EXPECT_EQ(drawReading(uint64_t{1} << 40, plainCut(), view).rgba, picture.rgba);
}

TEST_F(GpuCullingTest, leavesOutClustersOutsideThePicture) {
  render::MeshResidency meshes({});
  meshes.show(plainCut());
  meshes.uploadInRenderThread({.wait = true});
  const SeenPart part{&meshes.drawn()[0], 0, false};
  const core::View views[] = {fromAbove(), lookAt({2000, 2000, 700}, {2000, 2000, 0}),
                              lookAt({2000, 2000, 700}, {2000, 2000, 9000})};
  std::vector<uint64_t> triangles;
  for (const core::View& view : views) {
    GpuCulling culling;
    for (int frame = 0; frame < 4; ++frame) {
      culling.begin();
      culling.add({&part, 1}, meshes.pages(), 1, view, {});
      culling.findUnhidden();
      const render::Framebuffer target(view.width_px, view.height_px);
      startPicture(target, {});
      culling.findAppeared(target);
      glFinish();
    }
    triangles.push_back(culling.trianglesLately());
  }
  EXPECT_EQ(triangles[0], part.item->index_count / 3);
  EXPECT_LT(triangles[1], triangles[0] / 2);
  EXPECT_GT(triangles[1], 0u);
  EXPECT_EQ(triangles[2], 0u);
}

}  // namespace
}  // namespace lode::test
