#include "client/loadtest/request_trace.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/loadtest/recorded_requests.h"
#include "common/error.h"

namespace lode::app {
namespace {

RequestTrace someTrace() {
  RequestTrace trace;
  trace.build_id = {{std::byte{0xcd}}};
  trace.duration_s = 2;
  TracedRequest page{0, {{3, 900, {{std::byte{0xab}}}}, {}, proto::RequestClass::kVisible, 8.5f}, {}};
  TracedRequest mesh{
      0.1, {{4, 5000, {{std::byte{1}}}}, {}, proto::RequestClass::kMargin, 2}, core::DecodeJob()};
  mesh.decode->step = 0.25;
  mesh.decode->expected = {90, 60, {AttributeSet::kColour}, {{1, 2, 3}, {4, 5, 6}}};
  TracedRequest tile{
      0.1, {{5, 7000, {{std::byte{2}}}}, {}, proto::RequestClass::kPrefetch, 1}, core::DecodeJob()};
  tile.decode->use.kind = core::BlobKind::kTile;
  tile.decode->image_size = {512, 200};
  tile.decode->with_tail = true;
  trace.requests = {page, mesh, tile};
  return trace;
}

TEST(RequestTraceFile, readsBackAWrittenTrace) {
  const RequestTrace trace = someTrace();
  const RequestTrace read = parseRequestTrace(toJson(trace), "t");
  EXPECT_EQ(read.build_id, trace.build_id);
  EXPECT_EQ(read.duration_s, trace.duration_s);
  ASSERT_EQ(read.requests.size(), trace.requests.size());
  for (size_t i = 0; i < trace.requests.size(); ++i) {
    const TracedRequest &a = read.requests[i], &b = trace.requests[i];
    EXPECT_EQ(a.t_s, b.t_s);
    EXPECT_EQ(a.request.blob, b.request.blob);
    EXPECT_EQ(a.request.request_class, b.request.request_class);
    EXPECT_EQ(a.request.priority_px, b.request.priority_px);
    ASSERT_EQ(a.decode.has_value(), b.decode.has_value());
    if (!a.decode) continue;
    EXPECT_EQ(a.decode->use.kind, b.decode->use.kind);
    EXPECT_EQ(a.decode->expected.triangles, b.decode->expected.triangles);
    EXPECT_EQ(a.decode->expected.vertices, b.decode->expected.vertices);
    EXPECT_EQ(a.decode->expected.attributes.bits, b.decode->expected.attributes.bits);
    EXPECT_EQ(a.decode->image_size, b.decode->image_size);
    EXPECT_EQ(a.decode->with_tail, b.decode->with_tail);
  }
  EXPECT_EQ(read.requests[1].decode->step, 0.25);
  EXPECT_EQ(read.requests[1].decode->expected.box.max, glm::uvec3(4, 5, 6));
}

template <typename Action>
void expectTooMany(const Action& action) {
  try {
    action();
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kLimit);
    EXPECT_NE(std::string(error.what()).find("the path requests more than 3 blobs"), std::string::npos)
        << error.what();
  }
}

TEST(RecordedRequests, areRefusedAboveTheLimit) {
  RecordedRequests recorded(3);
  for (uint32_t number = 1; number <= 3; ++number) recorded.add({{number, 10, {}}, {}}, 0);
  expectTooMany([&] { recorded.add({{4, 10, {}}, {}}, 0); });
  EXPECT_EQ(recorded.take().size(), 3u);
}

TEST(RecordedRequests, areRefusedWithMoreBlobsToDecodeThanTheLimit) {
  RecordedRequests recorded(3);
  const auto addJob = [&](std::byte content) {
    core::DecodeJob job;
    job.bytes = {content};
    recorded.addJob(std::move(job));
  };
  for (const unsigned content : {1, 2, 3, 1}) addJob(std::byte(content));
  expectTooMany([&] { addJob(std::byte{4}); });
}

TEST(RecordedRequests, areGivenInOrderOfTimeWithTheirJobs) {
  RecordedRequests recorded;
  core::DecodeJob job;
  job.bytes = {std::byte{9}};
  const Digest name = digestOf(job.bytes);
  recorded.add({{1, 1, name}, {}}, 0.5);
  recorded.add({{2, 10, {}}, {}}, 0.25);
  recorded.addJob(std::move(job));
  const std::vector<TracedRequest> requests = recorded.take();
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].request.blob.number, 2u);
  EXPECT_FALSE(requests[0].decode);
  ASSERT_TRUE(requests[1].decode);
  EXPECT_TRUE(requests[1].decode->bytes.empty());
}

TEST(RequestTraceFile, refusesAnInvalidTraceAndNamesThePlace) {
  const std::string good = toJson(someTrace());
  const auto expectRefused = [](const std::string& text, const std::string& part) {
    try {
      parseRequestTrace(text, "trace.json");
      FAIL() << "not refused: " << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  expectRefused("[", "not JSON");
  expectRefused("[]", "the trace is not an object");
  expectRefused("{}", "trace.json: a trace of version 1");
  expectRefused(changed("\"version\":2", "\"version\":3"), "a trace of version 3");
  expectRefused(R"({"version": 2})", "build_id is missing");
  expectRefused(R"({"version": 2, "build_id": "00000000000000000000000000000000"})", "duration_s is missing");
  expectRefused(changed("\"requests\":[", "\"others\":["), "requests is not a list");
  expectRefused(changed("\"t\":0.1", "\"t\":7"), "requests[1].t is out of range");
  expectRefused(changed("\"t\":0.0", "\"t\":1.0"), "requests[1].t is before");
  expectRefused(changed("\"blob\":4", "\"blob\":-4"), "requests[1].blob is out of range");
  expectRefused(changed("\"bytes\":5000", "\"bytes\":4000000000"), "requests[1].bytes is out of range");
  expectRefused(changed("\"name\":\"ab", "\"name\":\"xy"), "requests[0].name");
  expectRefused(changed("\"class\":2", "\"class\":3"), "requests[2].class is out of range");
  expectRefused(changed("\"size\":[512,200]", "\"size\":[512]"), "requests[2].tile.size is not a list of 2");
  expectRefused(changed("\"triangles\":90", "\"triangles\":4000000"), "requests[1].mesh.triangles");
}

}  // namespace
}  // namespace lode::app
