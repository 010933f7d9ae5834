#include "client/loadtest/trace_client.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "client/net/exchange.h"
#include "common/codec/hierarchy_page.h"
#include "common/error.h"

namespace lode::app {
namespace {

constexpr auto kKeepAliveEvery = std::chrono::seconds(1);
constexpr auto kLookForRetryEvery = std::chrono::milliseconds(20);
/// The session limits the number of open requests. When fewer than kRefillBelow are open, the client passes
/// all due requests to the session again.
constexpr size_t kRefillBelow = 64;
/// Shortest duration of a round, because the trace of a resting camera has the duration 0.
constexpr double kShortestTraceSeconds = 1;

}  // namespace

TraceClient::TraceClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, double phase_s,
                         KnownDigests& names, LoadCounts& counts)
    : io_(io),
      plan_(plan),
      names_(names),
      counts_(counts),
      start_(start),
      random_(static_cast<uint64_t>(1000 * phase_s)),
      due_(start),
      connection_(sessionOptions(), static_cast<uint32_t>(1000 * phase_s)) {
  const auto& requests = plan.trace.requests;
  const auto at = std::ranges::lower_bound(requests, phase_s, {}, &TracedRequest::t_s);
  first_ = at == requests.end() ? 0 : static_cast<size_t>(at - requests.begin());
}

core::SessionOptions TraceClient::sessionOptions() {
  core::SessionOptions options = plan_.options.engine.session;
  options.model = plan_.model.model;
  options.matches_digest = [this](const BlobRef& blob, std::span<const std::byte> bytes) {
    return names_.matchesDigest(blob, bytes);
  };
  return options;
}

/// Returns the intended time of the next request. The first request of the next round follows the last
/// request of the trace.
core::TimePoint TraceClient::nextIntended() const noexcept {
  const auto& requests = plan_.trace.requests;
  const uint64_t place = first_ + replayed_;
  const double round_s = std::max(plan_.trace.duration_s, kShortestTraceSeconds);
  const size_t rounds = place / requests.size();
  const double t_s = static_cast<double>(rounds) * round_s + requests[place % requests.size()].t_s;
  return start_ + ofSeconds(t_s - requests[first_].t_s + paused_s_);
}

void TraceClient::goOn() {
  ++replayed_;
  if ((first_ + replayed_) % plan_.trace.requests.size() == 0)
    paused_s_ += randomPause(plan_.think_s, random_);
}

template <typename Action>
void TraceClient::guarded(const Action& action) {
  if (gone_ || survives(counts_, action)) return;
  gone_ = true;
  due_ = kNever;
}

void TraceClient::step(core::TimePoint now) {
  guarded([&] {
    counts_.started += !std::exchange(started_, true);
    ended_.reset();
    if (connection_.due(now)) connect(now);
    for (const core::SessionRole role : core::kSessionRoles)
      onSession(role, now, [&](core::Session& session) { session.tick(now); });
    addDueRequests(now);
    if (requests_wait_) sendRequests();
    send();
    scheduleNext(now);
  });
}

void TraceClient::connect(core::TimePoint now) {
  if (const core::Session* const older = connection_.session(core::SessionRole::kDraining);
      older != nullptr && connection_.session())
    counts_.failed_requests += older->openRequests();  // after two servers' shutdowns
  // An active session becomes the draining one. If there is none, the draining session keeps its transport.
  if (connection_.session()) leaving_ = std::move(newest_);
  newest_ = std::make_unique<net::TcpTransport>(io_, plan_.route, [this] { receive(); });
  connection_.begin({}, now);
}

/// Runs an action on a session. An Error ends the connection; any other exception ends the client.
template <typename Action>
void TraceClient::onSession(core::SessionRole role, core::TimePoint now, const Action& action) {
  core::Session* const session = connection_.session(role);
  if (session == nullptr) return;
  try {
    action(*session);
  } catch (const Error& error) {
    const bool leaves = role == core::SessionRole::kDraining || !connection_.takesRequests();
    const bool is_lost = !leaves || session->openRequests() > 0;
    counts_.lost += is_lost;
    counts_.failed_requests += session->openRequests();
    ended_ = std::move(transport(role));
    if (role == core::SessionRole::kActive)
      connection_.fail(error, now);
    else
      connection_.endDraining();
    if (is_lost) counts_.noteError(error);
    if (role == core::SessionRole::kDraining) sendRequests();
  }
}

void TraceClient::addDueRequests(core::TimePoint now) {
  const auto& requests = plan_.trace.requests;
  bool added = false;
  while (!requests.empty() && nextIntended() <= std::min(now, plan_.end)) {
    const size_t traced = (first_ + replayed_) % requests.size();
    const core::Request& request = requests[traced].request;
    added |= pending_.try_emplace(request.blob.number, Pending{request, nextIntended(), traced}).second;
    goOn();
  }
  if (added) sendRequests();
}

void TraceClient::sendRequests() {
  core::Session* const session = connection_.session();
  if (!connection_.takesRequests() || !session->opened()) return;
  const core::Session* const before = connection_.session(core::SessionRole::kDraining);
  std::vector<core::Request> requests;
  requests.reserve(pending_.size());
  for (const auto& [number, pending] : pending_)
    if (before == nullptr || !before->isRequested(pending.request.blob)) requests.push_back(pending.request);
  std::ranges::stable_sort(requests, [](const core::Request& a, const core::Request& b) {
    return a.request_class != b.request_class ? a.request_class < b.request_class
                                              : a.priority_px > b.priority_px;
  });
  requests_wait_ = !session->setRequests(requests);
}

void TraceClient::send() {
  for (const core::SessionRole role : core::kSessionRoles)
    if (core::Session* const session = connection_.session(role); session != nullptr)
      net::sendOutgoing(*transport(role), *session);
}

void TraceClient::scheduleNext(core::TimePoint now) {
  due_ =
      now + (connection_.takesRequests() ? core::TimePoint::duration(kKeepAliveEvery) : kLookForRetryEvery);
  if (!plan_.trace.requests.empty()) due_ = std::min(due_, nextIntended());
}

/// One session of the client, for net::exchange(). Handles the session's events.
class TraceClient::End {
 public:
  End(TraceClient& client, core::Session& session, core::SessionRole role, core::TimePoint now) noexcept
      : client_(client), session_(session), role_(role), now_(now) {}

  bool connected() const noexcept { return client_.connection_.session(role_) == &session_; }
  bool takesInput() const noexcept { return session_.takesInput(); }
  proto::Bytes takeOutgoing() { return session_.takeOutgoing(); }
  void receive(std::span<const std::byte> bytes) {
    session_.receive(bytes, now_);
    while (connected()) {
      const auto event = session_.nextEvent();
      if (!event) return;
      client_.handle(*event, session_, now_);
    }
  }

 private:
  TraceClient& client_;
  core::Session& session_;
  const core::SessionRole role_;
  const core::TimePoint now_;
};

void TraceClient::receive() {
  guarded([&] {
    const core::TimePoint now = std::chrono::steady_clock::now();
    for (const core::SessionRole role : core::kSessionRoles)
      onSession(role, now, [&](core::Session& session) {
        End end(*this, session, role, now);
        // Terminates: this thread receives no bytes while the loop runs.
        while (net::exchange(*transport(role), end)) continue;
      });
    if (requests_wait_) sendRequests();
    send();
  });
}

void TraceClient::handle(const core::SessionEvent& event, core::Session& session, core::TimePoint now) {
  if (const auto* opened = std::get_if<core::ModelOpened>(&event)) {
    checkBuild(plan_.trace, opened->summary.build_id, plan_.model.model);
    connection_.succeeded();
    was_let_in_ = true;
    turned_away_ = {};
    return sendRequests();
  }
  if (const auto* blob = std::get_if<core::BlobArrived>(&event)) return arrived(*blob, session, now);
  if (const auto* refused = std::get_if<core::BlobRefused>(&event)) {
    ++counts_.failed_requests;
    pending_.erase(refused->blob.number);
    counts_.noteError(Error(ErrorCode::kIo, "the server says: " + refused->message));
  }
  if (const auto* leaving = std::get_if<core::ServerLeaving>(&event)) {
    counts_.moved += session.opened();
    counts_.turned_away += !session.opened();
    if (!was_let_in_) turned_away_ = *leaving;
    connection_.leave(leaving->reason, now, leaving->remedy);
  }
}

void TraceClient::arrived(const core::BlobArrived& blob, core::Session& session, core::TimePoint now) {
  ++counts_.blobs;
  counts_.bytes += blob.bytes.size();
  const auto found = pending_.find(blob.blob.number);
  if (found != pending_.end()) {
    const Pending pending = found->second;
    pending_.erase(found);
    if (plan_.decode && plan_.trace.requests[pending.traced].decode) {
      core::DecodeJob job = *plan_.trace.requests[pending.traced].decode;
      job.bytes = blob.bytes;
      const core::DecodeResult result = core::runDecodeJob(job);
      if (!result.failure.empty())
        throw Error(ErrorCode::kFormat, "a blob cannot be decoded: " + result.failure);
    }
    counts_.latency[static_cast<size_t>(pending.request.request_class)].add(now - pending.intended);
    const size_t open = session.openRequests();
    if (open < kRefillBelow && open < pending_.size()) sendRequests();
  }
  if (blob.blob.number == first_lod_ && !image_seen_) {
    image_seen_ = true;
    counts_.first_image.add(now - start_);
  } else if (blob.use.kind == core::BlobKind::kRootPage) {
    const HierarchyPage page = decodePage(blob.bytes, kRootKey, true);
    const BlobRef& coarsest = page.nodes.front().lods.back().payload;
    first_lod_ = coarsest.number;
    if (coarsest) session.expectUnasked(coarsest, {});
  }
}

void TraceClient::finish(core::TimePoint now) {
  if (now < start_) return;
  if (!gone_) noteNeverLetIn(counts_, turned_away_);
  if (!image_seen_) counts_.first_image.add(now - start_);
  for (const auto& [number, pending] : pending_) {
    if (pending.intended > now) continue;
    ++counts_.unanswered;
    counts_.latency[static_cast<size_t>(pending.request.request_class)].add(now - pending.intended);
  }
}

}  // namespace lode::app
