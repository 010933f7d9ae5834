#include "client/render/residency/mesh_residency.h"

#include <array>
#include <set>

#include <gtest/gtest.h>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/triangle_clusters.h"
#include "residency_fixture.h"

namespace lode::test {
namespace {

using render::MeshResidency;

/// Uploads in small pieces until the newest cut is drawn, and checks the drawn cut after each.
template <typename Look>
int uploadSlowly(MeshResidency& residency, Look look) {
  int frames = 0;
  while (!residency.upToDate() && frames < 1000) {
    EXPECT_LE(residency.uploadInRenderThread({.bytes = 10'000, .ms = 1000}), 10'000u);
    look();
    ++frames;
  }
  return frames;
}

TEST_F(Residency, drawsTheOldRegionUntilAllOfTheNewOneIsUploaded) {
  MeshResidency residency({});
  residency.show(cutOf(std::vector{gridOf(1), gridOf(2)}));
  residency.uploadInRenderThread({.wait = true});
  ASSERT_TRUE(residency.upToDate());

  auto finer = std::make_shared<core::Cut>(*cutOf(std::vector{gridOf(3), gridOf(4), gridOf(5), gridOf(6)}));
  const NodeKey first = kRootKey.child(0), second = kRootKey.child(1);
  const std::array nodes{first.child(0), first.child(1), second.child(0), second.child(1)};
  for (size_t i = 0; i < nodes.size(); ++i) finer->parts[i].node = nodes[i];
  residency.show(finer);
  std::set<std::vector<NodeKey>> seen;
  const int frames = uploadSlowly(residency, [&] {
    std::vector<NodeKey> drawn;
    for (const render::DrawItem& item : residency.drawn()) drawn.push_back(item.node);
    seen.insert(drawn);
  });
  EXPECT_GT(frames, 8);
  EXPECT_EQ(seen,
            (std::set<std::vector<NodeKey>>{
                {first, second}, {first.child(0), first.child(1), second}, {nodes.begin(), nodes.end()}}));
}

TEST_F(Residency, drawsACutOfAnotherBuildOnlyWhenAllOfItIsUploaded) {
  MeshResidency residency({});
  residency.show(cutOf(std::vector{gridOf(1), gridOf(2)}));
  residency.uploadInRenderThread({.wait = true});
  auto next = std::make_shared<core::Cut>(*cutOf(std::vector{gridOf(3), gridOf(4)}));
  next->build = 1;
  residency.show(next);
  const auto before = residency.drawnCut();
  uploadSlowly(residency,
               [&] { EXPECT_TRUE(residency.drawnCut() == before || residency.drawnCut() == next); });
  EXPECT_EQ(residency.drawnCut(), next);
}

TEST_F(Residency, freesAllPagesUntilTheNextCutIsShown) {
  MeshResidency residency({.page_bytes = 64u << 10});
  const auto cut = cutOf(std::vector{gridOf(1), gridOf(2), gridOf(3), gridOf(4)});
  residency.show(cut);
  residency.uploadInRenderThread({.wait = true});
  const uint64_t held_bytes = residency.pages().capacityBytes(), serial = residency.drawnSerial();
  residency.release();
  EXPECT_EQ(residency.pages().capacityBytes(), 0u);
  EXPECT_EQ(residency.meshCount(), 0u);
  EXPECT_FALSE(residency.drawnCut());
  EXPECT_GT(residency.drawnSerial(), serial);
  EXPECT_TRUE(residency.upToDate());
  residency.show(cut);
  residency.uploadInRenderThread({.wait = true});
  EXPECT_EQ(residency.drawnCut(), cut);
  EXPECT_EQ(residency.pages().capacityBytes(), held_bytes);
}

TEST_F(Residency, freesAllPagesDuringAnUpload) {
  MeshResidency residency({});
  residency.show(cutOf(std::vector{gridOf(1), gridOf(2)}));
  residency.uploadInRenderThread({.wait = true});
  const auto next = cutOf(std::vector{gridOf(3), gridOf(4), gridOf(5)});
  residency.show(next);
  residency.uploadInRenderThread({.bytes = 10'000, .ms = 1000});
  residency.release();
  EXPECT_EQ(residency.pages().capacityBytes(), 0u);
  residency.show(next);
  uploadSlowly(residency, [] {});
  EXPECT_EQ(residency.drawnCut(), next);
}

/// One of the second cut's four regions is in progress when the third cut is shown.
TEST_F(Residency, switchesToANewerCutAfterOneRegionOfTheCurrentOne) {
  const auto cutFrom = [](uint32_t seed) {
    return cutOf(std::vector{gridOf(seed), gridOf(seed + 1), gridOf(seed + 2), gridOf(seed + 3)});
  };
  MeshResidency residency({});
  const auto first = cutFrom(1), second = cutFrom(11), third = cutFrom(21);
  residency.show(first);
  residency.uploadInRenderThread({.wait = true});
  residency.show(second);
  uint64_t bytes = residency.uploadInRenderThread({.bytes = 10'000, .ms = 1000});
  residency.show(third);
  std::set<const core::Cut*> complete;
  for (int frame = 0; frame < 1000 && !residency.upToDate(); ++frame) {
    bytes += residency.uploadInRenderThread({.bytes = 10'000, .ms = 1000});
    complete.insert(residency.drawnCut().get());
  }
  EXPECT_FALSE(complete.contains(second.get()));
  EXPECT_EQ(residency.drawnCut(), third);
  const uint64_t mesh_bytes = core::drawnBytes(*gridOf(1));
  EXPECT_EQ(bytes, 5 * mesh_bytes) << "a region of the second, and the third";
}

/// Otherwise a camera that starts to move would wait for a region with many parts.
TEST_F(Residency, switchesAtOnceToAMuchCoarserCut) {
  MeshResidency residency({});
  residency.show(cutOf(std::vector{gridOf(1)}));
  residency.uploadInRenderThread({.wait = true});
  residency.show(cutOf(std::vector{gridOf(2)}));
  uint64_t bytes = residency.uploadInRenderThread({.bytes = 1000, .ms = 1000});
  auto coarser = std::make_shared<core::Cut>(*cutOf(std::vector{gridOf(3)}));
  coarser->threshold_px = 8;
  residency.show(coarser);
  while (!residency.upToDate()) bytes += residency.uploadInRenderThread({.bytes = 10'000, .ms = 1000});
  EXPECT_EQ(residency.drawnCut(), coarser);
  EXPECT_LE(bytes, 1000 + core::drawnBytes(*gridOf(3)));
}

/// While the camera moves, pictures may have a lower resolution.
TEST_F(Residency, comparesCutsOfDifferentResolutionsByAngularError) {
  const auto isOvertaken = [](uint32_t older_px, uint32_t newer_px) {
    const auto pictured = [](uint32_t seed, uint32_t height_px) {
      auto cut = std::make_shared<core::Cut>(*cutOf(std::vector{gridOf(seed)}));
      cut->view.height_px = height_px;
      return cut;
    };
    MeshResidency residency({});
    residency.show(pictured(1, older_px));
    residency.uploadInRenderThread({.wait = true});
    residency.show(pictured(2, older_px));
    uint64_t bytes = residency.uploadInRenderThread({.bytes = 1000, .ms = 1000});
    residency.show(pictured(3, newer_px));
    while (!residency.upToDate()) bytes += residency.uploadInRenderThread({.bytes = 10'000, .ms = 1000});
    return bytes <= 1000 + core::drawnBytes(*gridOf(3));
  };
  EXPECT_TRUE(isOvertaken(720, 360));
  EXPECT_FALSE(isOvertaken(720, 720));
  EXPECT_FALSE(isOvertaken(360, 720));
}

TEST_F(Residency, publishesItsMixturesAndKeepsThemWhileDrawn) {
  MeshResidency residency({});
  residency.show(cutOf(std::vector{gridOf(1), gridOf(2)}));
  residency.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(residency.takeMixtures().empty());
  const auto next = cutOf(std::vector{gridOf(3), gridOf(4)});
  residency.show(next);
  std::set<std::shared_ptr<const core::Cut>> drawn, taken;
  uploadSlowly(residency, [&] {
    for (const auto& mixture : residency.takeMixtures()) taken.insert(mixture);
    if (residency.drawnCut() == next || residency.drawnCut()->parts[0].mesh != next->parts[0].mesh) return;
    drawn.insert(residency.drawnCut());
  });
  EXPECT_EQ(drawn.size(), 1u);
  EXPECT_EQ(taken, drawn);
}

TEST_F(Residency, evictsReplacedMeshesBeforeTheCutIsComplete) {
  const uint64_t mesh_bytes = core::drawnBytes(*gridOf(1));
  const auto page_bytes = static_cast<uint32_t>(mesh_bytes + 512);
  MeshResidency residency({.budget_bytes = 5 * page_bytes, .spare_bytes = 0, .page_bytes = page_bytes});
  residency.show(cutOf(std::vector{gridOf(1), gridOf(2), gridOf(3), gridOf(4)}));
  residency.uploadInRenderThread({.wait = true});
  residency.show(cutOf(std::vector{gridOf(5), gridOf(6), gridOf(7), gridOf(8)}));
  uploadSlowly(residency, [&] {
    ASSERT_EQ(residency.drawn().size(), 4u);
    EXPECT_LE(residency.meshCount(), 5u);
  });
  EXPECT_TRUE(residency.upToDate());
}

/// The root's fallback uploads first and is drawn for the third child until that is resident.
TEST_F(Residency, keepsAnUnneededFallbackUntilTheCutIsDrawn) {
  const auto withFallback = [](std::vector<std::shared_ptr<const Mesh>> meshes, uint32_t seed) {
    auto cut = std::make_shared<core::Cut>(*cutOf(meshes));
    cut->fallbacks.push_back(
        {{kRootKey, 0, false, 0, gridOf(seed)}, 0, static_cast<uint32_t>(meshes.size()), 0, 1, 0});
    return cut;
  };
  MeshResidency residency({.spare_bytes = 0});
  const auto before = withFallback({gridOf(1), gridOf(2)}, 3);
  before->left_out = {{kRootKey.child(2), {}}};
  residency.show(before);
  residency.uploadInRenderThread({.wait = true});
  const auto next = withFallback({gridOf(4), gridOf(5), gridOf(6)}, 7);
  next->parts[1].node = kRootKey.child(1).child(1);
  next->parts[2].node = kRootKey.child(2);
  next->parts[1].visible = next->parts[2].visible = false;
  next->left_out = {{kRootKey.child(1).child(0), {}}};
  residency.show(next);
  uploadSlowly(residency, [] {});
  ASSERT_EQ(residency.drawn().size(), 4u);
  EXPECT_GT(residency.drawn()[3].index_count, 0u);
}

TEST_F(Residency, drawsTheUploadedPartOfATooLargeCutAndThenTheNext) {
  const uint64_t mesh_bytes = core::drawnBytes(*gridOf(1, 31));
  ASSERT_NE(mesh_bytes % 16, 0u) << "two take more than twice as much";
  MeshResidency residency({.budget_bytes = 2 * mesh_bytes, .spare_bytes = 0, .page_bytes = 1024});
  residency.show(cutOf(std::vector{gridOf(1, 4)}));
  residency.uploadInRenderThread({.wait = true});
  residency.show(cutOf(std::vector{gridOf(2, 31), gridOf(3, 31)}));
  residency.uploadInRenderThread({.wait = true});
  ASSERT_TRUE(residency.overBudget());
  ASSERT_EQ(residency.drawn().size(), 1u);
  EXPECT_EQ(residency.drawn()[0].index_count, 3 * gridOf(2, 31)->triangles.size());
  const auto next = cutOf(std::vector{gridOf(4, 16), gridOf(5, 16)});
  residency.show(next);
  uploadSlowly(residency, [] {});
  EXPECT_EQ(residency.drawnCut(), next);
}

std::shared_ptr<const core::ViewCuts> viewCuts(std::vector<std::shared_ptr<const core::Cut>> cuts) {
  auto view_cuts = std::make_shared<core::ViewCuts>();
  view_cuts->cuts = std::move(cuts);
  view_cuts->all = core::gatherMeshes(view_cuts->cuts);
  return view_cuts;
}

TEST_F(Residency, exchangesTheCutsOfAModelInSeveralPlacesRegionByRegion) {
  MeshResidency residency({});
  residency.show(viewCuts({cutOf(std::vector{gridOf(1), gridOf(2)}), cutOf(std::vector{gridOf(3)})}));
  residency.uploadInRenderThread({.wait = true});
  const auto next = viewCuts({cutOf(std::vector{gridOf(4), gridOf(5)}), cutOf(std::vector{gridOf(6)})});
  residency.show(next);
  std::set<size_t> regions;  // regions that have switched
  uploadSlowly(residency, [&] {
    size_t changed = 0;
    for (size_t instance = 0; instance < 2; ++instance)
      for (size_t part = 0; part < residency.drawn(instance).size(); ++part) {
        EXPECT_GT(residency.drawn(instance)[part].index_count, 0u);
        changed += residency.drawnCut(instance)->parts[part].mesh == next->cuts[instance]->parts[part].mesh;
      }
    regions.insert(changed);
  });
  EXPECT_EQ(regions, (std::set<size_t>{0, 1, 2, 3}));
  EXPECT_TRUE(residency.upToDate());
}

TEST_F(Residency, holdsAMeshOfSeveralInstancesOnce) {
  const auto shared = gridOf(1);
  const uint64_t mesh_bytes = core::drawnBytes(*shared);
  MeshResidency residency({.budget_bytes = 2 * mesh_bytes});
  residency.show(
      viewCuts({cutOf(std::vector{shared}), cutOf(std::vector{shared}), cutOf(std::vector{shared})}));
  EXPECT_EQ(residency.uploadInRenderThread({.wait = true}), mesh_bytes);
  EXPECT_EQ(residency.meshCount(), 1u);
  EXPECT_TRUE(residency.upToDate());
}

TEST_F(Residency, uploadsNothingOfCutsOfSeveralPlacesThatDoNotFitTogether) {
  MeshResidency residency({.budget_bytes = core::drawnBytes(*gridOf(1)) * 3 / 2});
  residency.show(viewCuts({cutOf(std::vector{gridOf(1)}), cutOf(std::vector{gridOf(2)})}));
  EXPECT_EQ(residency.uploadInRenderThread({.wait = true}), 0u);
}

TEST_F(Residency, leavesTheRestOfAFramesBudgetToOthers) {
  render::Renderer renderer(1);
  renderer.show(cutOf(std::vector{gridOf(1)}));
  constexpr double kPlentyMs = 1e6;
  const render::UploadBudget left = renderer.uploadInRenderThread({.bytes = 10'000, .ms = kPlentyMs});
  EXPECT_LT(left.bytes, 10'000u);
  EXPECT_LT(left.ms, kPlentyMs);
  renderer.uploadInRenderThread({.wait = true});
  EXPECT_EQ(renderer.uploadInRenderThread({.bytes = 10'000}).bytes, 10'000u);
}

TEST_F(Residency, drawsACutOnlyWithItsFallbacksAndKeepsThem) {
  MeshResidency residency({.spare_bytes = 0});
  auto cut = std::make_shared<core::Cut>(*cutOf(std::vector{gridOf(1)}));
  cut->fallbacks.push_back({{kRootKey, 0, false, 0, gridOf(2, 64)}, 0, 1, 0, 0, 0});
  residency.show(cut);
  residency.uploadInRenderThread(
      {.bytes = static_cast<uint32_t>(core::drawnBytes(*cut->parts[0].mesh)), .ms = 1000});
  EXPECT_FALSE(residency.upToDate());
  residency.uploadInRenderThread({.wait = true});
  ASSERT_TRUE(residency.upToDate());
  EXPECT_EQ(residency.meshCount(), 2u);
  ASSERT_EQ(residency.drawn().size(), 2u);
  EXPECT_EQ(residency.drawn()[1].index_count, 3 * cut->fallbacks[0].part.mesh->triangles.size());

  residency.show(cutOf(std::vector{gridOf(3)}));
  residency.uploadInRenderThread({.bytes = 4000, .ms = 1000});
  EXPECT_GE(residency.meshCount(), 2u);
}

TEST_F(Residency, completesACutAlthoughNewerOnesKeepComing) {
  MeshResidency residency({});
  int switched = 0;
  const render::DrawItem* before = nullptr;
  uint32_t first_part = 0;
  for (uint32_t seed = 1; seed < 60; ++seed) {
    residency.show(cutOf(std::vector{gridOf(seed)}));
    residency.uploadInRenderThread({.bytes = 8'000, .ms = 1000});
    const auto drawn = residency.drawn();
    if (!drawn.empty() && (drawn.data() != before || drawn[0].base_vertex != first_part)) ++switched;
    before = drawn.data();
    if (!drawn.empty()) first_part = drawn[0].base_vertex;
  }
  EXPECT_GE(switched, 5);
}

/// Each cut has another fallback, and fallbacks are uploaded before other meshes.
TEST_F(Residency, drawsPartsOfCutsThatAreReplacedBeforeTheirFallbacksArrive) {
  MeshResidency residency({});
  const auto cutWithFallback = [](uint32_t seed) {
    auto cut = std::make_shared<core::Cut>(*cutOf(std::vector{gridOf(seed)}));
    cut->left_out = {{kRootKey.child(1), {}}};
    cut->fallbacks.push_back({{kRootKey, 0, false, 0, gridOf(1000 + seed)}, 0, 1, 0, 1, 0});
    return cut;
  };
  std::set<const Mesh*> drawn;
  std::vector<std::shared_ptr<const core::Cut>> alive;
  for (uint32_t seed = 1; seed < 60; ++seed) {
    alive.push_back(cutWithFallback(seed));
    residency.show(alive.back());
    residency.uploadInRenderThread({.bytes = 10'000, .ms = 1000});
    if (residency.drawnCut()) drawn.insert(residency.drawnCut()->parts[0].mesh.get());
  }
  EXPECT_GT(drawn.size(), 3u);
}

TEST_F(Residency, storesTheBoxesOfClusters) {
  for (const uint8_t attribute : {AttributeSet::kNormal, AttributeSet::kTexture}) {
    Mesh mesh = makeGrid(40, 40, {.attributes = {attribute}, .bump = 0.1});
    core::clusterTriangles(mesh);
    MeshResidency residency({.staging_bytes = 1000});
    residency.show(GlTest::cutOf({mesh}));
    residency.uploadInRenderThread({.wait = true});
    const render::DrawItem& item = residency.drawn()[0];
    std::vector<LatticeBox> boxes(mesh.cluster_boxes.size());
    glGetNamedBufferSubData(residency.pages().buffer(item.page), 4 * GLintptr{item.first_box_word},
                            static_cast<GLsizeiptr>(boxes.size() * sizeof(LatticeBox)), boxes.data());
    EXPECT_EQ(boxes, mesh.cluster_boxes);
  }
}

TEST_F(Residency, givesTrianglesWithoutClustersTheBoxOfTheirMesh) {
  const Mesh mesh = makeGrid(40, 40, {.attributes = {AttributeSet::kNormal}});
  MeshResidency residency({});
  residency.show(GlTest::cutOf({mesh}));
  residency.uploadInRenderThread({.wait = true});
  const render::DrawItem& item = residency.drawn()[0];
  const std::vector<LatticeBox> everywhere(clusterCount(mesh.triangles.size()), item.box);
  EXPECT_EQ(item.clusters->boxes, everywhere);
}

TEST_F(Residency, uploadsASharedMeshOnce) {
  MeshResidency residency({});
  const auto kept = gridOf(1);
  residency.show(cutOf(std::vector{kept}));
  residency.uploadInRenderThread({.wait = true});
  const auto added = gridOf(2);
  residency.show(cutOf(std::vector{kept, added}));
  EXPECT_EQ(residency.uploadInRenderThread({.wait = true}), core::drawnBytes(*added));
}

TEST_F(Residency, uploadsAMeshLargerThanTheStagingMemoryInPieces) {
  const auto large = gridOf(1, 100);
  MeshResidency residency({.staging_bytes = 4096});
  residency.show(cutOf(std::vector{large}));
  EXPECT_EQ(residency.uploadInRenderThread({.wait = true}), core::drawnBytes(*large));
  EXPECT_TRUE(residency.upToDate());
}

}  // namespace
}  // namespace lode::test
