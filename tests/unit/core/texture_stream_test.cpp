#include "client/core/textures/texture_stream.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

#include <gtest/gtest.h>

#include "client/core/engine.h"
#include "common/error.h"
#include "proto/limits.h"
#include "tests/support/texture_images.h"
#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using fixture::kStart;
using proto::Bytes;
using test::TextureImages;

constexpr uint32_t kPage = 1, kMesh = 2, kSet = 3, kFirstTile = 4;

void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

/// A textured square of 4096 steps with an image of 1000 x 600 texels: a coarse level of one tile and a fine
/// one of 2 x 2; and its server as bytes in process.
class TexturedEngine : public testing::Test {
 protected:
  void SetUp() override {
    makeMesh({0, 0});
    TextureImages images(1000, 600, [](uint32_t x, uint32_t y) { return glm::u8vec4(x / 4, y / 4, 0, 255); });
    uint32_t next = kFirstTile;
    images.forEachTile([&](uint32_t level, uint32_t x, uint32_t y) {
      blobs_[next] = test::webpOf(images.tile(level, x, y));
      images.texture().tiles[next - kFirstTile] = refOf(next);
      ++next;
    });
    set_.textures.push_back(images.texture());
    finishSet();
    near_.eye_model = {2048, 2048, 4000};
    far_.eye_model = {2048, 2048, 40000};
  }

  /// @param materials  materials of the square's two halves.
  void makeMesh(std::array<uint16_t, 2> materials) {
    Mesh mesh;
    mesh.attributes.bits = AttributeSet::kTexture | AttributeSet::kMaterial;
    for (const uint16_t material : materials) {
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      for (const glm::uvec2 corner : {glm::uvec2(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
        mesh.positions.push_back(packPosition({corner * 4096u, 0}));
        VertexAttributes attributes;
        attributes.texture = corner * 65535u;
        attributes.material = material;
        mesh.vertex_attributes.push_back(attributes);
      }
      mesh.triangles.push_back(first + glm::u32vec3(0, first == 0 ? 1 : 2, first == 0 ? 2 : 3));
    }
    const EncodedPayload payload = encodePayload(mesh, 1);
    blobs_[kMesh] = payload.bytes;
    vertices_ = payload.vertices;
  }

  /// Encodes the texture set and the page with the mesh.
  void finishSet() {
    blobs_[kSet] = encodeTextureSet(set_);
    Node root;
    root.key = kRootKey;
    root.box.add(glm::uvec3(0));
    root.box.add(glm::uvec3(4096, 4096, 0));
    root.lods = {{refOf(kMesh), 2, vertices_, 0, 0, 0}};
    blobs_[kPage] = encodePage({{root}});
  }

  BlobRef refOf(uint32_t number) const {
    const Bytes& blob = blobs_.at(number);
    return {number, static_cast<uint32_t>(blob.size()), digestOf(blob)};
  }

  Bytes blobFrames(uint32_t request, uint32_t number) const {
    const Bytes& blob = blobs_.at(number);
    Bytes frames;
    for (size_t at = 0; at < blob.size();) {
      const size_t part = std::min<size_t>(blob.size() - at, 16'000);
      const auto fields = proto::encodeBlobChunkHeader(
          {request, static_cast<uint32_t>(blob.size()), static_cast<uint32_t>(at)});
      const auto header = proto::encodeFrameHeader(
          {static_cast<uint32_t>(fields.size() + part), static_cast<uint8_t>(proto::FrameType::kBlob), 0, 0});
      frames.insert(frames.end(), header.begin(), header.end());
      frames.insert(frames.end(), fields.begin(), fields.end());
      frames.insert(frames.end(), blob.begin() + static_cast<std::ptrdiff_t>(at),
                    blob.begin() + static_cast<std::ptrdiff_t>(at + part));
      at += part;
    }
    return frames;
  }

  void open(EngineOptions options = {}) {
    options.session.model = "square";
    engine_.emplace(std::move(options));
    engine_->connect(kStart);
    engine_->setView(near_, 1);
    proto::Opened opened;
    opened.handle = 1;
    opened.summary.name = "square";
    opened.summary.nodes = 1;
    opened.summary.attributes.bits = AttributeSet::kTexture | AttributeSet::kMaterial;
    opened.summary.root_page = refOf(kPage);
    opened.summary.textures = refOf(kSet);
    Bytes bytes = proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 100, ""}, 1);
    append(bytes, proto::encode(opened, 2));
    append(bytes, blobFrames(0, kPage));
    append(bytes, blobFrames(0, kMesh));
    engine_->receive(bytes, kStart);
    engine_->takeOutgoing();
  }

  void decodeAll() {
    for (const DecodeJob& job : engine_->takeDecodeJobs()) {
      engine_->finishDecode(runDecodeJob(job));
      if (job.use.kind == BlobKind::kTile) decoded_.push_back(job.blob.number);
    }
  }

  /// Returns the blobs that the engine requests now, in order, with their request numbers.
  std::vector<std::pair<uint32_t, uint32_t>> takeRequests() {
    std::vector<std::pair<uint32_t, uint32_t>> requests;
    const Bytes sent = engine_->takeOutgoing();
    std::span<const std::byte> rest = sent;
    while (!rest.empty()) {
      const auto header = proto::decodeFrameHeader(rest.first<proto::kFrameHeaderBytes>());
      if (header.type == static_cast<uint8_t>(proto::FrameType::kRequests))
        for (const auto& change :
             proto::decode<proto::Requests>(rest.subspan(proto::kFrameHeaderBytes, header.body_bytes))
                 .changes)
          if (change.action == proto::RequestAction::kAdd) requests.emplace_back(change.blob, change.request);
      rest = rest.subspan(proto::kFrameHeaderBytes + header.body_bytes);
    }
    return requests;
  }

  /// Steps and answers requests, except refused ones, until no request is left. @return all requested blobs.
  std::vector<uint32_t> serve(const std::set<uint32_t>& refused = {},
                              proto::WireError why = proto::WireError::kDamagedStore) {
    std::vector<uint32_t> asked;
    for (int round = 0; round < 50; ++round) {
      decodeAll();
      engine_->step(kStart);
      const auto requests = takeRequests();
      if (requests.empty() && engine_->counts().decoding == 0) return asked;
      for (const auto& [blob, request] : requests) {
        asked.push_back(blob);
        engine_->receive(refused.contains(blob)
                             ? proto::encode(proto::ErrorMessage{why, request, false, "damaged"}, 0)
                             : blobFrames(request, blob),
                         kStart);
      }
    }
    ADD_FAILURE() << "it asks without an end";
    return asked;
  }

  uint32_t tiles() const { return static_cast<uint32_t>(set_.textures[0].tiles.size()); }

  std::map<uint32_t, Bytes> blobs_;
  TextureSet set_;
  uint32_t vertices_ = 0;
  View near_, far_;
  std::optional<Engine> engine_;
  std::vector<uint32_t> decoded_;
};

TEST_F(TexturedEngine, requestsTheSetThenTheCoarsestLevelThenTheRest) {
  open();
  const std::vector<uint32_t> asked = serve();
  ASSERT_EQ(asked.size(), 1u + tiles());
  EXPECT_EQ(asked[0], kSet);
  EXPECT_EQ(asked[1], kFirstTile);  // coarsest tiles first
  EXPECT_TRUE(engine_->settled());
  EXPECT_TRUE(engine_->cut()->converged);
  EXPECT_EQ(engine_->failure(), "");
}

TEST_F(TexturedEngine, givesTheCutTheSetAndItsResidentTiles) {
  open();
  decodeAll();
  engine_->step(kStart);
  ASSERT_TRUE(engine_->cut());
  EXPECT_FALSE(engine_->cut()->textures);
  EXPECT_FALSE(engine_->settled());
  EXPECT_FALSE(engine_->cut()->converged);
  serve();
  ASSERT_TRUE(engine_->cut()->textures);
  EXPECT_EQ(*engine_->cut()->textures, set_);
  ASSERT_EQ(engine_->cut()->tiles.size(), tiles());
  EXPECT_EQ(engine_->cut()->tiles.front().key, (TileKey{1, 0, 0, 0}));
  for (const ResidentTile& tile : engine_->cut()->tiles)
    EXPECT_EQ(tile.image->size, tileImageSize(set_, tile.key));
}

TEST_F(TexturedEngine, asksFromAfarForTheCoarsestLevelAlone) {
  open();
  engine_->setView(far_, 1);
  EXPECT_EQ(serve(), (std::vector<uint32_t>{kSet, kFirstTile}));
  EXPECT_TRUE(engine_->settled());
  engine_->setView(near_, 1);
  EXPECT_EQ(serve().size(), tiles() - 1);
  EXPECT_TRUE(engine_->settled());
}

TEST_F(TexturedEngine, countsTheMemoryOfTextures) {
  open();
  serve();
  uint64_t texture_bytes = 0;
  for (const auto& [number, blob] : blobs_)
    if (number >= kSet) texture_bytes += blob.size();
  EXPECT_EQ(engine_->counts().texture_blob_bytes, texture_bytes);
  EXPECT_EQ(engine_->counts().tiles, tiles());
  EXPECT_EQ(engine_->counts().tiles_left_out, 0u);
  EXPECT_EQ(engine_->cut()->blob_bytes, texture_bytes + blobs_.at(kMesh).size());
}

TEST_F(TexturedEngine, leavesOutFinerTilesThatTheBudgetDoesNotAllowAndSettles) {
  EngineOptions options;
  // The coarse tile takes a layer and its tail, each fine one a layer: two of five fit.
  options.memory_budget_bytes = kTextureBudgetShare * 11 * (1u << 18);
  open(options);
  EXPECT_EQ(serve().size(), 1u + 2u);
  EXPECT_TRUE(engine_->settled());
  EXPECT_TRUE(engine_->cut()->converged);
  EXPECT_EQ(engine_->counts().tiles_left_out, tiles() - 2u);
  EXPECT_LE(engine_->counts().texture_bytes, options.memory_budget_bytes / kTextureBudgetShare);
  EXPECT_EQ(engine_->cut()->tiles.front().key.level, 1u);
  for (int turn = 0; turn < 3; ++turn) {  // there and back: no tile is requested twice
    engine_->setView(turn % 2 == 0 ? far_ : near_, 1);
    EXPECT_TRUE(serve().empty());
    EXPECT_TRUE(engine_->settled());
  }
}

TEST_F(TexturedEngine, reportsAnUnavailableTileAndShowsTheCoarserOne) {
  open();
  const std::vector<uint32_t> asked = serve({kFirstTile + 1});
  EXPECT_EQ(std::count(asked.begin(), asked.end(), kFirstTile + 1), 1);
  EXPECT_NE(engine_->failure().find("damaged"), std::string::npos);
  EXPECT_TRUE(engine_->settled());
  EXPECT_TRUE(engine_->cut()->converged) << "nothing better can be had";
  EXPECT_EQ(engine_->cut()->tiles.size(), tiles() - 1);
}

TEST_F(TexturedEngine, countsUnavailableVisibleTilesInTheCut) {
  open();
  engine_->setView(far_, 1);
  serve({kFirstTile + 1});
  EXPECT_EQ(engine_->cut()->lost_tiles, 0u) << "from afar it needs the coarsest alone";
  engine_->setView(near_, 1);
  serve({kFirstTile + 1});
  EXPECT_EQ(engine_->cut()->lost_tiles, 1u);
}

TEST_F(TexturedEngine, doesNotConvergeWithoutATemporarilyRefusedTile) {
  open();
  serve({kFirstTile + 1}, proto::WireError::kInternal);
  EXPECT_TRUE(engine_->settled());
  EXPECT_FALSE(engine_->cut()->converged);
}

TEST_F(TexturedEngine, saysWhyWhenATileIsNoImage) {
  blobs_[kFirstTile + 1] = Bytes(300);
  set_.textures[0].tiles[1] = refOf(kFirstTile + 1);
  finishSet();
  open();
  const std::vector<uint32_t> asked = serve();
  EXPECT_EQ(std::count(asked.begin(), asked.end(), kFirstTile + 1), 1);
  EXPECT_NE(engine_->failure().find("JPEG"), std::string::npos) << engine_->failure();
  EXPECT_EQ(engine_->cut()->tiles.size(), tiles() - 1);
}

TEST_F(TexturedEngine, showsTheModelUntexturedIfTheSetIsUnavailable) {
  open();
  EXPECT_EQ(serve({kSet}), std::vector<uint32_t>{kSet});
  EXPECT_NE(engine_->failure(), "");
  EXPECT_TRUE(engine_->cut()->converged) << "nothing better can be had";
  EXPECT_EQ(engine_->cut()->triangles, 2u);
  EXPECT_FALSE(engine_->cut()->textures);
  EXPECT_EQ(engine_->cut()->lost_tiles, 1u) << "it counts as one";
}

TEST_F(TexturedEngine, remembersLostBlobsOnlyIfTheyAreTilesOfTheSet) {
  TextureStream textures(refOf(kSet), 1ull << 30);
  for (uint32_t blob = 1; blob < kFirstTile + tiles(); ++blob)
    if (blob != kSet) textures.lose(blob);
  textures.takeSet(blobs_.at(kSet));
  const TextureFootprint footprint{{}, {{.texture = 0, .texels_per_model = 600.0f / 4096}}};
  const TexturedPart part{&footprint, 4000, true};
  textures.refine({&part, 1}, near_, 1);
  EXPECT_EQ(textures.lostCount(), 0u) << "before the set, any number of blobs could be lost";
  EXPECT_EQ(textures.missing().size(), tiles());
  textures.lose(kFirstTile);
  textures.refine({&part, 1}, near_, 1);
  EXPECT_EQ(textures.lostCount(), 1u);
}

TEST_F(TexturedEngine, givesUpOnAnInvalidSet) {
  blobs_[kSet] = Bytes(40, std::byte{7});
  open();
  EXPECT_THROW(serve(), Error);
}

TEST_F(TexturedEngine, givesUpOnASetWhoseTilesShareABlobInDifferentSizes) {
  set_.textures[0].tiles[1] = set_.textures[0].tiles[4];
  finishSet();
  open();
  EXPECT_THROW(serve(), Error);
}

TEST_F(TexturedEngine, requestsASharedTileBlobOnce) {
  set_.textures.push_back(set_.textures[0]);
  makeMesh({0, 1});
  finishSet();
  open();
  EXPECT_EQ(serve().size(), 1u + tiles());
  EXPECT_EQ(engine_->cut()->tiles.size(), 2 * tiles());
  EXPECT_EQ(engine_->counts().tiles, tiles());
}

TEST_F(TexturedEngine, settlesWithoutTilesWhereTheImageIsMissing) {
  set_.textures[0] = {"gone.png", 0, 0, {}};
  finishSet();
  open();
  EXPECT_EQ(serve(), std::vector<uint32_t>{kSet});
  EXPECT_TRUE(engine_->settled());
}

}  // namespace
}  // namespace lode::core
