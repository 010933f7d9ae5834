#include "client/web/core/job_codec.h"

#include <random>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::web {
namespace {

core::DecodeJob jobOf(core::BlobKind kind) {
  core::DecodeJob job;
  job.use.kind = kind;
  job.bytes = {std::byte{1}, std::byte{2}, std::byte{3}};
  job.step = 0.125;
  job.expected = {40, 22, {AttributeSet::kColour}, {{1, 2, 3}, {4, 5, 6}}};
  job.image_size = {2, 3};
  auto set = std::make_shared<TextureSet>();
  set->uv_origin = {0.5, -2};
  set->uv_scale_exponent = 3;
  set->textures = {{"a name that workers do not need", 640, 480, {}}, {}};
  job.textures = std::move(set);
  return job;
}

Mesh meshOf() {
  Mesh mesh;
  mesh.attributes.bits = AttributeSet::kColour;
  mesh.positions = {packPosition({1, 2, 3}), packPosition({kMaxLattice, 0, 5}), packPosition({7, 8, 9})};
  mesh.vertex_attributes.resize(3);
  mesh.vertex_attributes[1].colour = {1, 2, 3, 4};
  mesh.triangles = {{0, 1, 2}};
  mesh.cluster_boxes = {{{1, 0, 3}, {kMaxLattice, 8, 9}}};
  return mesh;
}

TEST(JobCodec, keepsWhatAWorkerNeedsOfAJob) {
  const core::DecodeJob job = jobOf(core::BlobKind::kMesh);
  const JobMessage decoded = decodeJob(encodeJob(17, job));
  EXPECT_EQ(decoded.number, 17u);
  EXPECT_EQ(decoded.job.use.kind, core::BlobKind::kMesh);
  EXPECT_EQ(decoded.job.bytes, job.bytes);
  EXPECT_EQ(decoded.job.step, job.step);
  EXPECT_EQ(decoded.job.expected.vertices, 22u);
  EXPECT_EQ(decoded.job.expected.box, job.expected.box);
  ASSERT_EQ(decoded.job.textures->textures.size(), 2u);
  EXPECT_EQ(decoded.job.textures->textures[0].width, 640u);
  EXPECT_EQ(decoded.job.textures->uv_scale_exponent, 3);
}

TEST(JobCodec, keepsAMeshAndItsFootprint) {
  core::DecodeResult result;
  result.decoded = std::make_shared<const Mesh>(meshOf());
  core::TextureFootprint footprint;
  footprint.tiles = {{1, 2, 3, 4.5f}};
  footprint.whole = {{0, 8}};
  result.footprint = std::make_shared<const core::TextureFootprint>(footprint);
  const ResultMessage decoded = decodeResult(encodeResult(5, result));
  EXPECT_EQ(decoded.number, 5u);
  EXPECT_EQ(*decoded.result.decoded, meshOf());
  EXPECT_EQ(*decoded.result.footprint, footprint);
  EXPECT_EQ(decoded.result.image, nullptr);
}

TEST(JobCodec, keepsAnImageWithItsTail) {
  core::DecodeJob job = jobOf(core::BlobKind::kTile);
  job.image_size = {8, 6};
  job.with_tail = true;
  const std::vector<uint8_t> texels(size_t{8} * 6 * 4, 200);
  const core::DecodeResult result = takeImage(job, texels, {8, 6});
  const ResultMessage decoded = decodeResult(encodeResult(1, result));
  ASSERT_NE(decoded.result.image, nullptr);
  EXPECT_EQ(*decoded.result.image, *result.image);
  EXPECT_FALSE(decoded.result.image->coarser.empty());
}

TEST(JobCodec, refusesAnImageOfAnotherSize) {
  const core::DecodeJob job = jobOf(core::BlobKind::kTile);
  const std::vector<uint8_t> texels(size_t{4} * 4 * 4);
  EXPECT_NE(takeImage(job, texels, {4, 4}).failure, "");
  EXPECT_EQ(takeImage(job, texels, {4, 4}).image, nullptr);
  EXPECT_NE(takeImage(job, {}, {0, 0}).failure, "");
}

TEST(JobCodec, refusesEveryTruncatedMessage) {
  core::DecodeResult result;
  result.decoded = std::make_shared<const Mesh>(meshOf());
  const Bytes job = encodeJob(1, jobOf(core::BlobKind::kMesh)), answer = encodeResult(1, result);
  for (size_t length = 0; length < job.size(); ++length)
    EXPECT_THROW(decodeJob(std::span(job).first(length)), Error) << length;
  for (size_t length = 0; length < answer.size(); ++length)
    EXPECT_THROW(decodeResult(std::span(answer).first(length)), Error) << length;
}

}  // namespace
}  // namespace lode::web
