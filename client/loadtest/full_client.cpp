#include "client/loadtest/full_client.h"

#include <algorithm>
#include <utility>

#include "client/net/exchange.h"
#include "common/error.h"

namespace lode::app {

FullClient::FullClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, uint64_t seed,
                       KnownDigests& names, LoadCounts& counts)
    : io_(io),
      plan_(plan),
      seed_(seed),
      names_(names),
      counts_(counts),
      start_(start),
      due_(start),
      noted_until_(start),
      random_(seed),
      engine_(engineOptions(seed)) {}

core::EngineOptions FullClient::engineOptions(uint64_t seed) {
  core::EngineOptions options = plan_.options.engine;
  options.session.model = plan_.model.model;
  options.session.matches_digest = [this](const BlobRef& blob, std::span<const std::byte> bytes) {
    return noteBlob(blob, bytes);
  };
  options.on_broken = [this](core::SessionRole role, const Error& why, bool is_last) {
    noteBroken(role, why, is_last);
  };
  options.on_turned_away = [this](const core::ServerLeaving& why) {
    ++counts_.turned_away;
    turned_away_ = why;
  };
  options.on_refused = [this](const BlobRef& blob, const std::string& why) { noteRefused(blob, why); };
  options.refine.hysteresis_factor = core::kHysteresisFactor;
  options.prefetch = true;
  options.jitter_seed = static_cast<uint32_t>(seed);
  return options;
}

bool FullClient::noteBlob(const BlobRef& blob, std::span<const std::byte> bytes) {
  ++counts_.blobs;
  for (RequestClock& clock : clocks_)
    if (const auto request = clock.arrived(blob.number))
      noteLatency(*request, std::chrono::steady_clock::now());
  return names_.matchesDigest(blob, bytes);
}

void FullClient::noteLatency(const RequestClock::Request& request, core::TimePoint now) {
  counts_.latency[static_cast<size_t>(request.request_class)].add(now - request.sent);
}

/// Counts a broken connection, unless the server has announced its shutdown and no requests were open. @param
/// is_last  true if the failure ends the client; guarded() then counts the error.
void FullClient::noteBroken(core::SessionRole role, const Error& why, bool is_last) {
  const uint64_t open = engine_.openRequests(role);
  if ((role == core::SessionRole::kActive && engine_.staysConnected()) || open > 0) {
    ++counts_.lost;
    if (!is_last) counts_.noteError(why);
  }
  counts_.failed_requests += open;
  lose(role);
}

/// Moves the open requests of a connection to lost_. The client repeats them if the view still needs them.
void FullClient::lose(core::SessionRole role) {
  const auto left_out = addLost(lost_, std::exchange(clocks_[static_cast<size_t>(role)], {}).open());
  counts_.unanswered += left_out.size();
  for (const auto& [blob, request] : left_out) noteLatency(request, std::chrono::steady_clock::now());
}

void FullClient::noteRefused(const BlobRef& blob, const std::string& why) {
  ++counts_.failed_requests;
  for (RequestClock& clock : clocks_) clock.refused(blob.number);
  counts_.noteError(Error(ErrorCode::kIo, "the server says: " + why));
}

template <typename Action>
void FullClient::guarded(const Action& action) {
  if (gone_ || survives(counts_, action)) return;
  gone_ = true;
  due_ = kNever;
}

void FullClient::step(core::TimePoint now) {
  guarded([&] {
    counts_.started += !std::exchange(started_, true);
    ended_.clear();
    note(now);
    keepConnected(now);
    look(now);
    work(now);
    while (due_ <= now) due_ = start_ + ofSeconds(static_cast<double>(++frames_) / plan_.fps);
  });
}

void FullClient::keepConnected(core::TimePoint now) {
  if (!engine_.wantsConnection(now)) return;
  auto& [newest, leaving] = transports_;
  if (engine_.connected()) {
    // The active connection becomes the draining one. Drop an older draining connection, which exists if two
    // servers shut down in short succession.
    counts_.failed_requests += engine_.openRequests(core::SessionRole::kDraining);
    lose(core::SessionRole::kDraining);
    leaving = std::move(newest);
    auto& [newest_clock, leaving_clock] = clocks_;
    leaving_clock = std::exchange(newest_clock, {});
  }
  newest = std::make_unique<net::TcpTransport>(io_, plan_.route, [this] { receive(); });
  engine_.connect(now);
}

/// One connection of the client's engine, for net::exchange(). Records the sent requests, and counts moves to
/// other servers.
class FullClient::End : public net::EngineEnd {
 public:
  End(FullClient& client, core::SessionRole role, core::TimePoint now) noexcept
      : net::EngineEnd(client.engine_, role, now), client_(client), role_(role), now_(now) {}

  proto::Bytes takeOutgoing() {
    proto::Bytes frames = net::EngineEnd::takeOutgoing();
    client_.clocks_[static_cast<size_t>(role_)].sent(frames, now_, client_.lost_);
    return frames;
  }
  void receive(std::span<const std::byte> bytes) {
    const core::Engine& engine = client_.engine_;
    const bool stayed = engine.staysConnected();
    net::EngineEnd::receive(bytes);
    client_.counts_.moved += stayed && engine.connected() && !engine.staysConnected();
  }

 private:
  FullClient& client_;
  const core::SessionRole role_;
  const core::TimePoint now_;
};

void FullClient::receive() {
  guarded([&] {
    const core::TimePoint now = std::chrono::steady_clock::now();
    note(now);
    for (const core::SessionRole role : core::kSessionRoles) {
      auto& transport = transports_[static_cast<size_t>(role)];
      if (!transport) continue;
      try {
        End end(*this, role, now);
        // Terminates: this thread receives no bytes while the loop runs.
        while (net::exchange(*transport, end)) continue;
      } catch (const Error& failed) {
        engine_.disconnect(failed, now, role);
      }
      if (!engine_.connected(role)) ended_.push_back(std::move(transport));
    }
    if (path_.keys.empty()) look(now);  // the model may have arrived, so do not wait for the next frame
    work(now);
  });
}

void FullClient::look(core::TimePoint now) {
  const ModelSummary* const model = engine_.summary();
  if (model == nullptr) return;
  if (path_.keys.empty()) {
    path_ = plan_.path_of(*model, seed_);
    round_begin_ = start_;
    pause_s_ = randomPause(plan_.think_s, random_);
  }
  engine_.setView(core::toView(camera(now), path_.fov_y_deg, plan_.size_px.x, plan_.size_px.y, *model),
                  plan_.pixels);
}

/// Returns the camera at a time. In each round, the camera follows the path, then rests at its end for the
/// pause.
core::CameraKey FullClient::camera(core::TimePoint now) {
  const double from_s = path_.keys.front().t, path_s = path_.keys.back().t - from_s;
  while (path_s > 0 && now >= round_begin_ + ofSeconds(path_s + pause_s_)) {
    round_begin_ += ofSeconds(path_s + pause_s_);
    pause_s_ = randomPause(plan_.think_s, random_);
  }
  const double at_s = std::chrono::duration<double>(now - round_begin_).count();
  return core::cameraAt(path_, from_s + std::min(at_s, path_s));
}

/// Steps the engine, sends its requests and decodes blobs. Repeats these steps until no blob is left to
/// decode.
void FullClient::work(core::TimePoint now) {
  for (bool decoded = true; decoded;) {
    engine_.step(now);
    for (const core::SessionRole role : core::kSessionRoles) {
      End end(*this, role, now);
      if (const auto& transport = transports_[static_cast<size_t>(role)]) net::sendOutgoing(*transport, end);
    }
    const std::vector<core::DecodeJob> jobs = engine_.takeDecodeJobs();
    for (const core::DecodeJob& job : jobs) decode(job);
    decoded = !jobs.empty();
  }
  const uint64_t received = engine_.counts().received_bytes;
  counts_.bytes += received - std::exchange(received_bytes_, received);
  const core::Cut* const cut = engine_.cut().get();
  // Returns the time since the start, including decoding.
  const auto sinceStart = [&] { return std::chrono::steady_clock::now() - start_; };
  if (cut != nullptr && !std::exchange(image_seen_, true)) counts_.first_image.add(sinceStart());
  const bool has_all = cut != nullptr && cut->converged;
  if (has_all && !std::exchange(converged_, true)) counts_.converged.add(sinceStart());
  if (has_all && engine_.staysConnected()) lost_.clear();  // the view no longer needs the lost requests
}

void FullClient::decode(const core::DecodeJob& job) {
  core::DecodeResult result = core::runDecodeJob(job);
  if (!result.failure.empty()) throw Error(ErrorCode::kFormat, "a blob cannot be decoded: " + result.failure);
  engine_.finishDecode(std::move(result));
}

/// Adds the time since the last call to looked_s and, if the picture is far too coarse or the client has
/// ended, to far_off_s.
void FullClient::note(core::TimePoint now) {
  if (now <= noted_until_) return;
  const double seconds = std::chrono::duration<double>(now - std::exchange(noted_until_, now)).count();
  const core::Cut* const cut = engine_.cut().get();
  counts_.looked_s += seconds;
  if (gone_ || core::isFarOff(cut, plan_.pixels)) counts_.far_off_s += seconds;
}

void FullClient::finish(core::TimePoint now) {
  if (now < start_) return;
  note(now);
  if (!gone_ && engine_.summary() == nullptr) noteNeverLetIn(counts_, turned_away_);
  for (const RequestClock& clock : clocks_) {
    for (const auto& [blob, request] : clock.open()) noteLatency(request, now);
    counts_.unanswered += clock.open().size();
  }
  if (!engine_.connected()) {
    for (const auto& [blob, request] : lost_) noteLatency(request, now);
    counts_.unanswered += lost_.size();
  }
  if (!image_seen_) counts_.first_image.add(now - start_);
  if (!converged_) counts_.converged.add(now - start_);
}

}  // namespace lode::app
