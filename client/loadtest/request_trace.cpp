#include "client/loadtest/request_trace.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include <asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include "client/loadtest/recorded_requests.h"
#include "client/loadtest/request_watch.h"
#include "client/net/exchange.h"
#include "client/net/tcp_transport.h"
#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/io/file_io.h"
#include "common/limits.h"

namespace lode::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kStepSeconds = 0.1;
constexpr size_t kMaxSteps = 36'000;  ///< largest number of steps of a path: one hour

core::EngineOptions engineOptions(const stream::ServedModel& model, core::EngineOptions options) {
  options.session.model = model.model;
  return options;
}

/// A client that follows the path as fast as it can and records its requests.
class Recorder {
 public:
  Recorder(const stream::ServedModel& model, const stream::StreamOptions& options, Clock::time_point deadline)
      : deadline_(deadline),
        where_(stream::toString(model)),
        server_(model.address),
        engine_(engineOptions(model, options.engine)),
        transport_(io_, stream::routeTo(model, options), [] {}) {
    engine_.connect(Clock::now());
  }

  const ModelSummary& open() {
    while (engine_.summary() == nullptr) exchange();
    return *engine_.summary();
  }

  /// Records the requests for a view, until its cut has settled. @param t_s  time of the requests in the
  /// trace.
  void recordView(const core::View& view, float pixels, double t_s) {
    t_s_ = t_s;
    engine_.setView(view, pixels);
    do {
      exchange();
    } while (!settled());
  }

  const std::string& gap() const { return engine_.failure(); }

  std::vector<TracedRequest> take() { return recorded_.take(); }

 private:
  /// The engine's connection, for net::exchange(). Shows the bytes of both directions to overheard_.
  class End : public net::EngineEnd {
   public:
    explicit End(Recorder& recorder) noexcept
        : net::EngineEnd(recorder.engine_, core::SessionRole::kActive, Clock::now()), recorder_(recorder) {}

    proto::Bytes takeOutgoing() {
      proto::Bytes frames = net::EngineEnd::takeOutgoing();
      recorder_.overheard_.sent(frames, recorder_.t_s_);
      return frames;
    }
    void receive(std::span<const std::byte> bytes) {
      net::EngineEnd::receive(bytes);
      recorder_.overheard_.received(bytes);
    }

   private:
    Recorder& recorder_;
  };

  bool settled() const { return engine_.settled() && engine_.cut(); }

  void exchange() {
    try {
      step();
    } catch (const Error& failed) {
      throw net::naming(server_, failed);
    }
  }

  /// Steps the engine. Unless the cut has settled, also sends the engine's requests and handles received
  /// bytes.
  void step() {
    engine_.step(Clock::now());
    if (settled()) return;
    End end(*this);
    net::sendOutgoing(transport_, end);
    io_.run_one_for(std::chrono::milliseconds(10));
    net::exchange(transport_, end);
    if (!engine_.trouble().empty())
      throw Error(ErrorCode::kNetwork, engine_.trouble(), engine_.troubleRemedy());
    for (core::DecodeJob& job : engine_.takeDecodeJobs()) {
      engine_.finishDecode(core::runDecodeJob(job));
      recorded_.addJob(std::move(job));
    }
    if (!engine_.failure().empty() && engine_.settled() && !engine_.cut())
      throw Error(ErrorCode::kNetwork, where_ + ": " + engine_.failure());
    if (Clock::now() > deadline_)
      throw Error(ErrorCode::kTimeout,
                  where_ + ": the path was not recorded in time; allow more with --timeout, or a larger " +
                      "error with --pixels");
  }

  const Clock::time_point deadline_;
  const std::string where_;
  const net::Address server_;
  double t_s_ = 0;
  RecordedRequests recorded_;
  OverheardRequests overheard_{
      [this](const core::Request& request, double t_s) { recorded_.add(request, t_s); }};
  core::Engine engine_;
  asio::io_context io_{1};
  net::TcpTransport transport_;
};

using Json = nlohmann::ordered_json;

[[noreturn]] void refuse(std::string_view source, const std::string& what) {
  throw Error(ErrorCode::kInput, std::string(source) + ": " + what + "; replay --record writes such files");
}

/// Reads the members of one JSON object of a trace and checks their limits.
class Reader {
 public:
  Reader(const Json& json, std::string where, std::string_view source)
      : json_(json), where_(std::move(where)), source_(source) {
    if (!json_.is_object()) refuse(source_, where_ + " is not an object");
  }

  bool has(const char* name) const { return json_.contains(name); }

  double number(const char* name, double most) const {
    const Json& value = member(name);
    const double number = value.is_number() ? value.get<double>() : -1;
    if (!(number >= 0 && number <= most)) refuse(source_, where_ + "." + name + " is out of range");
    return number;
  }

  uint32_t count(const char* name, uint32_t most) const { return toCount(member(name), name, most); }

  std::vector<uint32_t> counts(const char* name, size_t size, uint32_t most) const {
    const Json& value = member(name);
    if (!value.is_array() || value.size() != size)
      refuse(source_, where_ + "." + name + " is not a list of " + std::to_string(size) + " numbers");
    std::vector<uint32_t> counts;
    for (const Json& each : value) counts.push_back(toCount(each, name, most));
    return counts;
  }

  Digest name(const char* name) const {
    const Json& value = member(name);
    const std::string text = value.is_string() ? value.get<std::string>() : std::string();
    Digest result;
    if (text.size() != 2 * result.bytes.size() ||
        text.find_first_not_of("0123456789abcdef") != std::string::npos)
      refuse(source_, where_ + "." + name + " is not a name of 32 hexadecimal digits");
    for (size_t i = 0; i < result.bytes.size(); ++i)
      result.bytes[i] = static_cast<std::byte>(std::stoul(text.substr(2 * i, 2), nullptr, 16));
    return result;
  }

  Reader below(const char* name) const { return {member(name), where_ + "." + name, source_}; }

 private:
  const Json& member(const char* name) const {
    const auto found = json_.find(name);
    if (found == json_.end()) refuse(source_, where_ + "." + name + " is missing");
    return *found;
  }

  uint32_t toCount(const Json& value, const char* name, uint32_t most) const {
    if (!value.is_number_unsigned() || value.get<uint64_t>() > most)
      refuse(source_, where_ + "." + name + " is out of range");
    return value.get<uint32_t>();
  }

  const Json& json_;
  std::string where_;
  std::string_view source_;
};

constexpr uint32_t kAny = std::numeric_limits<uint32_t>::max();
constexpr double kLongestTraceSeconds = 1e6;

void writeDecode(Json& json, const core::DecodeJob& job) {
  if (job.use.kind == core::BlobKind::kTile) {
    json["tile"] = {{"size", {job.image_size.x, job.image_size.y}}, {"tail", job.with_tail ? 1 : 0}};
    return;
  }
  const PayloadExpectation& mesh = job.expected;
  json["mesh"] = {
      {"triangles", mesh.triangles},
      {"vertices", mesh.vertices},
      {"attributes", mesh.attributes.bits},
      {"box",
       {mesh.box.min.x, mesh.box.min.y, mesh.box.min.z, mesh.box.max.x, mesh.box.max.y, mesh.box.max.z}}};
}

core::DecodeJob readMesh(const Reader& mesh, double step) {
  core::DecodeJob job;
  job.step = step;
  job.expected.triangles = mesh.count("triangles", kMaxLodTriangles);
  job.expected.vertices = mesh.count("vertices", kMaxLodVertices);
  job.expected.attributes.bits =
      static_cast<decltype(job.expected.attributes.bits)>(mesh.count("attributes", 255));
  const std::vector<uint32_t> box = mesh.counts("box", 6, kMaxLattice);
  job.expected.box = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  return job;
}

core::DecodeJob readTile(const Reader& tile) {
  core::DecodeJob job;
  const std::vector<uint32_t> size = tile.counts("size", 2, kTilePx);
  job.image_size = {size[0], size[1]};
  job.with_tail = tile.count("tail", 1) != 0;
  job.use.kind = core::BlobKind::kTile;
  return job;
}

TracedRequest readRequest(const Reader& json, double duration_s, double step) {
  TracedRequest traced;
  traced.t_s = json.number("t", duration_s);
  traced.request.blob = {json.count("blob", kAny), json.count("bytes", kMaxBlobBytes), json.name("name")};
  traced.request.request_class = static_cast<proto::RequestClass>(
      json.count("class", static_cast<uint32_t>(proto::RequestClass::kPrefetch)));
  traced.request.priority_px = static_cast<float>(json.number("px", std::numeric_limits<float>::max()));
  if (json.has("mesh")) traced.decode = readMesh(json.below("mesh"), step);
  if (json.has("tile")) traced.decode = readTile(json.below("tile"));
  return traced;
}

}  // namespace

void checkBuild(const RequestTrace& trace, const Digest& build_id, const std::string& source) {
  if (trace.build_id == build_id) return;
  throw Error(ErrorCode::kInput, source + ": the trace is of another build of the model (" +
                                     toHex(trace.build_id) + ", and this one is " + toHex(build_id) +
                                     "): record it again with replay --record");
}

RequestTrace recordTrace(const stream::ServedModel& model, const stream::StreamOptions& options,
                         const PathOf& path_of, glm::uvec2 size_px, float pixels,
                         std::chrono::milliseconds timeout) {
  Recorder recorder(model, options, Clock::now() + timeout);
  const ModelSummary& summary = recorder.open();
  const core::CameraPath path = path_of(summary);
  const double begin_s = path.keys.front().t;
  RequestTrace trace;
  trace.build_id = summary.build_id;
  trace.duration_s = path.keys.back().t - begin_s;
  if (trace.duration_s > kStepSeconds * kMaxSteps)
    throw Error(ErrorCode::kUsage, "a camera path of more than an hour: shorten it");
  const auto steps = static_cast<size_t>(std::ceil(trace.duration_s / kStepSeconds));
  for (size_t i = 0; i <= steps; ++i) {
    const double t_s = std::min(kStepSeconds * static_cast<double>(i), trace.duration_s);
    const core::CameraKey camera = core::cameraAt(path, begin_s + t_s);
    recorder.recordView(core::toView(camera, path.fov_y_deg, size_px.x, size_px.y, summary), pixels, t_s);
  }
  trace.gap = recorder.gap();
  trace.requests = recorder.take();
  return trace;
}

std::string toJson(const RequestTrace& trace) {
  Json json;
  json["version"] = kTraceVersion;
  json["build_id"] = toHex(trace.build_id);
  json["duration_s"] = trace.duration_s;
  json["step"] = 1.0;
  json["requests"] = Json::array();
  for (const TracedRequest& traced : trace.requests) {
    Json entry{{"t", traced.t_s},
               {"blob", traced.request.blob.number},
               {"bytes", traced.request.blob.bytes},
               {"name", toHex(traced.request.blob.digest)},
               {"class", static_cast<uint32_t>(traced.request.request_class)},
               {"px", traced.request.priority_px}};
    if (traced.decode) writeDecode(entry, *traced.decode);
    if (traced.decode && traced.decode->use.kind != core::BlobKind::kTile) json["step"] = traced.decode->step;
    json["requests"].push_back(std::move(entry));
  }
  return json.dump();
}

RequestTrace parseRequestTrace(std::string_view text, std::string_view source) {
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) refuse(source, "not JSON");
  const Reader reader(json, "the trace", source);
  const uint32_t version = reader.has("version") ? reader.count("version", kAny) : 1;
  if (version != kTraceVersion)
    throw Error(ErrorCode::kInput, std::string(source) + ": a trace of version " + std::to_string(version) +
                                       ", and this program reads version " + std::to_string(kTraceVersion) +
                                       ": record it again with replay --record");
  RequestTrace trace;
  trace.build_id = reader.name("build_id");
  trace.duration_s = reader.number("duration_s", kLongestTraceSeconds);
  const double step = reader.number("step", std::numeric_limits<double>::max());
  const auto requests = json.find("requests");
  if (requests == json.end() || !requests->is_array()) refuse(source, "requests is not a list");
  if (requests->size() > kMaxTracedRequests)
    throw Error(ErrorCode::kLimit, std::string(source) + ": " + std::to_string(requests->size()) +
                                       " requests; the limit is " + std::to_string(kMaxTracedRequests) +
                                       ": record a shorter path");
  for (size_t i = 0; i < requests->size(); ++i) {
    trace.requests.push_back(
        readRequest({(*requests)[i], "requests[" + std::to_string(i) + "]", source}, trace.duration_s, step));
    if (i > 0 && trace.requests[i].t_s < trace.requests[i - 1].t_s)
      refuse(source, "requests[" + std::to_string(i) + "].t is before the request before it");
  }
  return trace;
}

void writeRequestTrace(AtomicFile file, const RequestTrace& trace) {
  const std::string text = toJson(trace) + '\n';
  file.write(std::as_bytes(std::span(text)));
  file.commit();
}

RequestTrace readRequestTrace(const std::filesystem::path& file) {
  refuseUnlessFile(file, "a trace of replay --record");
  std::error_code failed;
  const uint64_t bytes = std::filesystem::file_size(file, failed);
  if (!failed && bytes > kMaxTraceFileBytes)
    throw Error(ErrorCode::kLimit, file.string() + ": a trace of " + std::to_string(bytes) +
                                       " bytes; the limit is " + std::to_string(kMaxTraceFileBytes));
  std::ifstream in(file, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (failed || !in) throw Error(ErrorCode::kIo, file.string() + " cannot be read; check the path");
  return parseRequestTrace(text, file.string());
}

}  // namespace lode::app
