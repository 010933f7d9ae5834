// Tests of the C API with a server: views, cuts and textures.

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/app/cli/child_server.h"
#include "client/embed/lodestream.h"
#include "tests/integration/streaming/streaming_fixture.h"

namespace lode::test {
namespace {

using namespace std::chrono_literals;
using lodestream::Cut;
using lodestream::Status;
using lodestream::Stream;
using lodestream::View;

constexpr uint32_t kNewsMs = 60'000;  // longer than all waits in these tests

/// A program that embeds the library.
class EmbeddedStream : public Streaming {
 protected:
  /// Replaces the model by one with texture coordinates and materials 0 and 1.
  void serveTextured(TextureSet set) {
    SyntheticModel model = makeModel(
        makeSphere(96, 64,
                   {.attributes = {AttributeSet::kTexture | AttributeSet::kMaterial}, .extent = 4000}),
        {.leaf_triangles = 200});
    writeStore(folder_ / "next.lode", model, [&](store::Writer&) { return set; });
    std::filesystem::rename(folder_ / "next.lode", folder_ / "a.lode");
    server_->reload();
  }

  static TextureSet missingImage() {
    TextureSet set;
    set.textures.emplace_back().name = "missing.png";
    return set;
  }

  Stream open() const {
    Stream stream(stream::toString(served_));
    while (stream.step(kNewsMs).is_open == 0) continue;
    return stream;
  }

  /// Returns a view of the box's centre from the front, at a multiple of its width.
  static View viewOf(const Stream& stream, double distance) { return viewOf(stream.describe(), distance); }
  static View viewOf(const lodestream::Model& model, double distance) {
    View view{};
    for (int axis = 0; axis < 3; ++axis) {
      view.target[axis] = (model.box_min[axis] + model.box_max[axis]) / 2;
      view.eye[axis] = view.target[axis];
    }
    view.eye[2] += distance * (model.box_max[0] - model.box_min[0]);
    view.up[1] = 1;
    view.fov_y_deg = 45;
    view.width_px = 640;
    view.height_px = 480;
    view.threshold_px = 1;
    return view;
  }

  static Status settle(Stream& stream, const View& view) {
    stream.setView(view);
    Status status{};
    while (status.is_settled == 0) status = stream.step(kNewsMs);
    return status;
  }
};

TEST_F(EmbeddedStream, agreesWithItsCutOnConvergence) {
  Stream stream = open();
  View view = viewOf(stream, 1.7);
  for (const float threshold_px : {1.0f, 100.0f, 1e-6f}) {
    view.threshold_px = threshold_px;
    const Status status = settle(stream, view);
    const Cut cut = stream.takeCut();
    ASSERT_TRUE(cut);
    const bool is_within = cut->max_error_px <= threshold_px;
    EXPECT_EQ(status.is_converged != 0, is_within) << threshold_px;
    EXPECT_EQ(cut->is_converged != 0, is_within) << threshold_px;
  }
}

TEST_F(EmbeddedStream, distinguishesTheFinestCutFromALimitedCut) {
  Stream stream = open();
  View view = viewOf(stream, 1.7);
  view.threshold_px = 1e-6f;
  const Status status = settle(stream, view);
  EXPECT_EQ(status.is_converged + status.is_limited, 0u);
  EXPECT_EQ(status.is_finest, 1u);
  EXPECT_EQ(stream.takeCut()->is_finest, 1u);

  view.threshold_px = 100;
  EXPECT_EQ(settle(stream, view).is_finest, 0u);
  EXPECT_EQ(stream.takeCut()->is_finest, 0u);

  lodestream::Options options{};
  options.triangle_budget = 1;
  Stream limited(stream::toString(served_), options);
  while (limited.step(kNewsMs).is_open == 0) continue;
  view.threshold_px = 1e-6f;
  const Status stuck = settle(limited, view);
  EXPECT_EQ(stuck.is_limited, 1u);
  EXPECT_EQ(stuck.is_finest, 0u);
  EXPECT_EQ(limited.takeCut()->is_finest, 0u);
}

TEST_F(EmbeddedStream, givesEachNewCutAHigherSerial) {
  Stream stream = open();
  View view = viewOf(stream, 1.7);
  const Status first = settle(stream, view);
  EXPECT_GT(first.cut_serial, 0u);
  EXPECT_EQ(stream.takeCut()->serial, first.cut_serial);
  EXPECT_EQ(stream.takeCut()->serial, first.cut_serial);
  EXPECT_EQ(stream.step(0).cut_serial, first.cut_serial);
  view.eye[0] += 1;
  const Status second = settle(stream, view);
  EXPECT_GT(second.cut_serial, first.cut_serial);
  EXPECT_EQ(stream.takeCut()->serial, second.cut_serial);
}

TEST_F(EmbeddedStream, returnsAtOnceIfTheSameViewHasSettled) {
  Stream stream = open();
  const View view = viewOf(stream, 1.7);
  settle(stream, view);
  const auto begin = std::chrono::steady_clock::now();
  stream.setView(view);
  EXPECT_EQ(stream.step(5000).is_settled, 1u);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5000ms);
}

TEST_F(EmbeddedStream, namesTheOptionForAMissingToken) {
  const app::ChildServer child(folder_ / "a.lode");
  try {
    Stream stream(stream::toString(child.served()));
    while (stream.step(kNewsMs).is_open == 0) continue;
    FAIL() << "no error";
  } catch (const lodestream::Error& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("requires a token; set the option token to a valid one"), std::string::npos) << said;
  }
}

TEST_F(EmbeddedStream, isNotReconnectingOnceItHasEnded) {
  const std::unique_ptr<lodestream_stream, void (*)(lodestream_stream*)> stream(
      lodestream_open(stream::toString(served_).c_str(), nullptr), &lodestream_close);
  Status status{};
  while (status.is_open == 0) lodestream_step(stream.get(), kNewsMs, &status);
  lodestream_model model;
  lodestream_describe(stream.get(), &model);
  const View view = viewOf(model, 1.7);
  lodestream_set_view(stream.get(), &view);
  while (status.is_settled == 0) lodestream_step(stream.get(), kNewsMs, &status);
  stopServer();
  while (status.is_reconnecting == 0) lodestream_step(stream.get(), kNewsMs, &status);
  SyntheticModel other = makeModel(makeSphere(96, 64), {.leaf_triangles = 200, .lattice = {{0, 0, 0}, 1}});
  writeStore(folder_ / "a.lode", other);
  startServer();
  while (status.has_ended == 0) lodestream_step(stream.get(), kNewsMs, &status);
  EXPECT_EQ(status.is_reconnecting, 0u);
  const std::string said = lodestream_last_error();
  EXPECT_NE(said.find("replaced the model by one of another size or position"), std::string::npos) << said;
}

TEST_F(EmbeddedStream, hasNoTexturesForCoordinatesWithoutImages) {
  serveTextured({});
  Stream stream = open();
  EXPECT_EQ(stream.describe().has_textures, 0u);
  settle(stream, viewOf(stream, 1.7));
  const Cut cut = stream.takeCut();
  EXPECT_EQ(cut->textures, 0u);
  const lodestream::Mesh mesh = cut.mesh(0);
  EXPECT_NE(mesh->texture_uvs, nullptr);
  EXPECT_EQ(mesh->texture_of, nullptr);
}

TEST_F(EmbeddedStream, givesVerticesAnExistingTextureOrNone) {
  serveTextured(missingImage());
  Stream stream = open();
  EXPECT_EQ(stream.describe().has_textures, 1u);
  settle(stream, viewOf(stream, 1.7));
  const Cut cut = stream.takeCut();
  ASSERT_EQ(cut->textures, 1u);
  std::map<uint16_t, uint32_t> vertices_of;
  for (size_t part = 0; part < cut->parts; ++part) {
    const lodestream::Mesh mesh = cut.mesh(part);
    ASSERT_NE(mesh->texture_of, nullptr);
    for (uint32_t vertex = 0; vertex < mesh->vertices; ++vertex) ++vertices_of[mesh->texture_of[vertex]];
  }
  EXPECT_EQ(vertices_of.size(), 2u);
  EXPECT_GT(vertices_of[0], 0u);
  EXPECT_GT(vertices_of[LODESTREAM_NO_TEXTURE], 0u);
}

TEST_F(EmbeddedStream, givesMeshesOfOneIdTheSameArrays) {
  serveTextured(missingImage());
  Stream stream = open();
  stream.setView(viewOf(stream, 1.7));
  std::map<uint64_t, bool> has_uvs;
  // References that keep the cuts, because mesh ids are unique only among existing cuts.
  std::vector<Cut> held;
  for (Status status{}; status.is_settled == 0;) {
    status = stream.step(kNewsMs);
    const Cut& cut = held.emplace_back(stream.takeCut());
    for (size_t part = 0; cut && part < cut->parts; ++part) {
      const bool has = cut.mesh(part)->texture_uvs != nullptr;
      EXPECT_EQ(has_uvs.try_emplace(cut.part(part).mesh, has).first->second, has);
    }
  }
}

}  // namespace
}  // namespace lode::test
