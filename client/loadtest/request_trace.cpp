#include "client/loadtest/request_trace.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <asio/io_context.hpp>

#include "client/loadtest/overheard_requests.h"
#include "client/net/tcp_transport.h"
#include "common/error.h"

namespace lode::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kStepSeconds = 0.1;
constexpr size_t kMaxSteps = 36'000;  ///< an hour of a path

core::EngineOptions engineOptions(const stream::ServedModel& model, core::EngineOptions options) {
  options.session.model = model.model;
  return options;
}

/// One client that goes along the path as fast as it can, and notes what it requests.
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

  /// @param t_s  of the trace.
  void see(const core::View& view, float pixels, double t_s) {
    t_s_ = t_s;
    engine_.setView(view, pixels);
    do {
      exchange();
    } while (!settled());
  }

  const std::string& gap() const { return engine_.failure(); }

  std::vector<TracedRequest> take() {
    for (TracedRequest& traced : requests_)
      if (const auto job = jobs_.find(traced.request.blob.digest); job != jobs_.end())
        traced.decode = job->second;
    std::ranges::stable_sort(requests_, {}, &TracedRequest::t_s);
    return std::move(requests_);
  }

 private:
  bool settled() const { return engine_.settled() && engine_.cut(); }

  void exchange() {
    try {
      step();
    } catch (const Error& failed) {
      throw net::naming(server_, failed);
    }
  }

  /// Of the engine, and if it misses anything, what the server has to say.
  void step() {
    engine_.step(Clock::now());
    if (settled()) return;
    proto::Bytes frames = engine_.takeOutgoing();
    overheard_.sent(frames, t_s_);
    transport_.send(std::move(frames));
    io_.run_one_for(std::chrono::milliseconds(10));
    const proto::Bytes bytes = transport_.takeReceived();
    engine_.receive(bytes, Clock::now());
    overheard_.received(bytes);
    if (!engine_.trouble().empty()) throw Error(ErrorCode::kNetwork, engine_.trouble());
    for (core::DecodeJob& job : engine_.takeDecodeJobs()) {
      engine_.finishDecode(core::runDecodeJob(job));
      const Digest name = digestOf(job.bytes);
      job.bytes = {};
      jobs_.emplace(name, std::move(job));
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
  std::vector<TracedRequest> requests_;
  OverheardRequests overheard_{[this](const core::Request& request, double t_s) {
    requests_.push_back({t_s, request, {}});
  }};
  std::map<Digest, core::DecodeJob> jobs_;
  core::Engine engine_;
  asio::io_context io_{1};
  net::TcpTransport transport_;
};

}  // namespace

void checkBuild(const RequestTrace& trace, const Digest& build_id, const std::string& source) {
  if (trace.build_id == build_id) return;
  throw Error(ErrorCode::kInput, source + ": the trace is of another build of the model (" +
                                     toHex(trace.build_id) + ", and this one is " + toHex(build_id) +
                                     "): record it anew with replay --record");
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
    recorder.add(core::toView(camera, path.fov_y_deg, size_px.x, size_px.y, summary), pixels, t_s);
  }
  trace.gap = recorder.gap();
  trace.requests = recorder.take();
  return trace;
}

}  // namespace lode::app
