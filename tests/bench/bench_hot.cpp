// Measures functions that run for each byte built, sent and received: payloads, blobs of a store, a session's
// frames.

#include <benchmark/benchmark.h>

#include "client/core/lod/triangle_clusters.h"
#include "common/codec/draco_codec.h"
#include "server/store/reader.h"
#include "tests/support/synthetic_store.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/core/session_fixture.h"

namespace lode {
namespace {

constexpr double kStep = 1.0 / 1024;
constexpr uint32_t kSide =
    90;  // squares along a side; the grid has about as many triangles as a node of the default capacity

Mesh leafMesh() {
  return test::makeGrid(kSide, kSide, {.attributes = {AttributeSet::kNormal | AttributeSet::kColour}});
}

void countTriangles(benchmark::State& state, const Mesh& mesh) {
  state.counters["triangles"] = benchmark::Counter(static_cast<double>(mesh.triangles.size()),
                                                   benchmark::Counter::kIsIterationInvariantRate);
}

void encodeAPayload(benchmark::State& state) {
  const Mesh mesh = leafMesh();
  for (auto _ : state) benchmark::DoNotOptimize(encodePayload(mesh, kStep));
  countTriangles(state, mesh);
}
BENCHMARK(encodeAPayload)->Unit(benchmark::kMillisecond);

void decodeAPayload(benchmark::State& state) {
  const Mesh mesh = leafMesh();
  const EncodedPayload payload = encodePayload(mesh, kStep);
  const PayloadExpectation expected{static_cast<uint32_t>(mesh.triangles.size()), payload.vertices,
                                    mesh.attributes, test::boxOf(mesh)};
  for (auto _ : state) benchmark::DoNotOptimize(decodePayload(payload.bytes, kStep, expected));
  countTriangles(state, mesh);
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations() * payload.bytes.size()));
}
BENCHMARK(decodeAPayload)->Unit(benchmark::kMillisecond);

void clusterAMesh(benchmark::State& state) {
  const Mesh mesh = leafMesh();
  for (auto _ : state) {
    Mesh copy = mesh;
    core::clusterTriangles(copy);
    benchmark::DoNotOptimize(copy);
  }
  countTriangles(state, mesh);
}
BENCHMARK(clusterAMesh)->Unit(benchmark::kMillisecond);

/// Reads blobs and compares their checksums; the file stays in the page cache.
void readBlobsOfAStore(benchmark::State& state) {
  const test::WorkFolder folder;
  test::SyntheticModel model = test::makeModel(leafMesh(), {.leaf_triangles = 512});
  test::writeStore(folder / "a.lode", model);
  const store::Reader reader(folder / "a.lode");
  uint32_t number = 0;
  int64_t bytes = 0;
  for (auto _ : state) {
    const std::vector<std::byte> blob = reader.readBlob(1 + number++ % reader.blobCount());
    bytes += static_cast<int64_t>(blob.size());
    benchmark::DoNotOptimize(blob);
  }
  state.SetBytesProcessed(bytes);
}
BENCHMARK(readBlobsOfAStore);

void openAStore(benchmark::State& state) {
  const test::WorkFolder folder;
  test::SyntheticModel model = test::makeModel(leafMesh(), {.leaf_triangles = 64});
  test::writeStore(folder / "a.lode", model);
  for (auto _ : state) benchmark::DoNotOptimize(store::Reader(folder / "a.lode").blobCount());
  state.counters["nodes"] = static_cast<double>(model.nodes.size());
}
BENCHMARK(openAStore)->Unit(benchmark::kMicrosecond);

/// Receives requested blobs in reads of 64 KB and compares their digests.
void receiveBlobs(benchmark::State& state) {
  using namespace core::fixture;
  constexpr uint32_t kBlobs = 64;
  constexpr size_t kReadBytes = 64 << 10;
  const auto blob_bytes = static_cast<size_t>(state.range(0));
  core::Session session(optionsFor("model"), kStart);
  const auto receive = [&](std::span<const std::byte> bytes) {
    size_t arrived = 0;
    for (; !bytes.empty(); bytes = bytes.subspan(std::min(bytes.size(), kReadBytes))) {
      session.receive(bytes.first(std::min(bytes.size(), kReadBytes)), kStart);
      while (session.nextEvent()) ++arrived;
      session.takeOutgoing();  // credit for the server
    }
    return arrived;
  };
  receive(welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes));
  session.takeOutgoing();
  std::vector<core::Request> requests;
  for (uint32_t i = 0; i < kBlobs; ++i)
    requests.push_back({blobRef(100 + i, blob_bytes), {}, proto::RequestClass::kVisible, 10});
  for (auto _ : state) {
    state.PauseTiming();
    session.setRequests(requests);
    Bytes frames;
    for (const proto::RequestChange& change : changesOf(session.takeOutgoing()))
      frames = std::move(frames) + blobFrames(change.request, change.blob, blob_bytes);
    state.ResumeTiming();
    if (receive(frames) != kBlobs) return state.SkipWithError("not all blobs arrived");
  }
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations() * kBlobs * blob_bytes));
}
BENCHMARK(receiveBlobs)->Arg(8 << 10)->Arg(64 << 10)->Unit(benchmark::kMicrosecond);

void readRequests(benchmark::State& state) {
  proto::Requests requests;
  for (uint32_t i = 0; i < 1024; ++i) {
    proto::RequestChange change;
    change.request = i + 1;
    change.blob = 1000 + i;
    requests.changes.push_back(change);
  }
  const std::vector<std::byte> frame = proto::encode(requests, 0);
  const auto body = std::span(frame).subspan(proto::kFrameHeaderBytes);
  for (auto _ : state) benchmark::DoNotOptimize(proto::decode<proto::Requests>(body));
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * requests.changes.size()));
}
BENCHMARK(readRequests)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace lode

BENCHMARK_MAIN();
