#include "client/app/cli/load_client.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "common/error.h"
#include "common/hierarchy_page.h"

namespace lode::app {
namespace {

constexpr auto kNever = core::TimePoint::max();
constexpr auto kKeepAliveEvery = std::chrono::seconds(1);
constexpr auto kLookForRetryEvery = std::chrono::milliseconds(20);
constexpr std::array kLines{core::Line::kNewest, core::Line::kLeaving};
constexpr size_t kRefillBelow = 64;  ///< open wishes; the session holds back what is above its own limits
constexpr double kShortestTraceSeconds = 1;  ///< a path that stands still is replayed this often

}  // namespace

void LoadTally::add(const LoadTally& other) {
  for (size_t i = 0; i < latency.size(); ++i) latency[i].add(other.latency[i]);
  first_image.add(other.first_image);
  blobs += other.blobs;
  bytes += other.bytes;
  errors += other.errors;
  unanswered += other.unanswered;
  moved += other.moved;
  lost += other.lost;
  failed_wishes += other.failed_wishes;
  if (first_error.empty()) first_error = other.first_error;
}

LoadClient::LoadClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, double phase_s,
                       KnownNames& names, LoadTally& tally)
    : io_(io),
      plan_(plan),
      names_(names),
      tally_(tally),
      start_(start),
      due_(start),
      link_(sessionOptions(), static_cast<uint32_t>(1000 * phase_s)) {
  const auto& wishes = plan.trace.wishes;
  const auto at = std::ranges::lower_bound(wishes, phase_s, {}, &TracedWish::t_s);
  first_ = at == wishes.end() ? 0 : static_cast<size_t>(at - wishes.begin());
}

core::SessionOptions LoadClient::sessionOptions() {
  core::SessionOptions options;
  options.model = plan_.model.model;
  options.token = plan_.options.token;
  options.is_named = [this](const BlobRef& blob, std::span<const std::byte> bytes) {
    return names_.isNamed(blob, bytes);
  };
  return options;
}

/// The time of the replay's n-th wish: places after the trace's end are those of its next round.
core::TimePoint LoadClient::intendedTime(uint64_t replay) const noexcept {
  const auto& wishes = plan_.trace.wishes;
  const uint64_t place = first_ + replay;
  const double round_s = std::max(plan_.trace.duration_s, kShortestTraceSeconds);
  const size_t rounds = place / wishes.size();
  const double t_s = static_cast<double>(rounds) * round_s + wishes[place % wishes.size()].t_s;
  return start_ + ofSeconds(t_s - wishes[first_].t_s);
}

void LoadClient::noteError(const std::string& what) {
  if (tally_.first_error.empty()) tally_.first_error = what;
  ++tally_.errors;
}

/// What goes wrong with one client is counted and ends it; the others go on.
template <typename Action>
void LoadClient::guarded(const Action& action) {
  if (gone_) return;
  try {
    action();
  } catch (const std::exception& error) {
    noteError(error.what());
    gone_ = true;
    due_ = kNever;
  }
}

void LoadClient::step(core::TimePoint now) {
  guarded([&] {
    ended_.reset();
    if (link_.due(now)) connect(now);
    for (const core::Line line : kLines)
      onLine(line, now, [&](core::Session& session) { session.tick(now); });
    addDueWishes(now);
    send();
    scheduleNext(now);
  });
}

void LoadClient::connect(core::TimePoint now) {
  if (const core::Session* const older = link_.session(core::Line::kLeaving);
      older != nullptr && link_.session())
    tally_.failed_wishes += older->openWishes();  // two servers left one soon after the other
  leaving_ = std::move(newest_);
  newest_ = std::make_unique<net::TcpTransport>(io_, plan_.route, [this] { receive(); });
  link_.begin({}, now);
  first_rung_ = 0;
}

/// What the network does to a connection ends it; what else goes wrong ends the client.
template <typename Action>
void LoadClient::onLine(core::Line line, core::TimePoint now, const Action& action) {
  core::Session* const session = link_.session(line);
  if (session == nullptr) return;
  try {
    action(*session);
  } catch (const Error& error) {
    const bool leaves = line == core::Line::kLeaving || !link_.takesWishes();
    if (!leaves || session->openWishes() > 0) ++tally_.lost;
    tally_.failed_wishes += session->openWishes();
    ended_ = std::move(transport(line));
    if (line == core::Line::kLeaving) return link_.endLeaving();
    link_.fail(error, now);
  }
}

void LoadClient::addDueWishes(core::TimePoint now) {
  const auto& wishes = plan_.trace.wishes;
  bool added = false;
  while (!wishes.empty() && intendedTime(replayed_) <= std::min(now, plan_.end)) {
    const size_t traced = (first_ + replayed_) % wishes.size();
    const core::Wish& wish = wishes[traced].wish;
    added |= pending_.try_emplace(wish.blob.number, Pending{wish, intendedTime(replayed_), traced}).second;
    ++replayed_;
  }
  if (added) sendWishes();
}

void LoadClient::sendWishes() {
  core::Session* const session = link_.session();
  if (!link_.takesWishes() || !session->opened()) return;
  const core::Session* const before = link_.session(core::Line::kLeaving);
  std::vector<core::Wish> wishes;
  wishes.reserve(pending_.size());
  for (const auto& [number, pending] : pending_)
    if (before == nullptr || !before->isWishedFor(pending.wish.blob)) wishes.push_back(pending.wish);
  std::ranges::stable_sort(wishes, [](const core::Wish& a, const core::Wish& b) {
    return a.wish_class != b.wish_class ? a.wish_class < b.wish_class : a.priority_px > b.priority_px;
  });
  session->setWishes(wishes);
}

void LoadClient::send() {
  for (const core::Line line : kLines)
    if (core::Session* const session = link_.session(line); session != nullptr)
      transport(line)->send(session->takeOutgoing());
}

void LoadClient::scheduleNext(core::TimePoint now) {
  due_ = now + (link_.takesWishes() ? core::TimePoint::duration(kKeepAliveEvery) : kLookForRetryEvery);
  if (!plan_.trace.wishes.empty()) due_ = std::min(due_, intendedTime(replayed_));
}

void LoadClient::receive() {
  guarded([&] {
    const core::TimePoint now = std::chrono::steady_clock::now();
    for (const core::Line line : kLines)
      onLine(line, now, [&](core::Session& session) {
        session.receive(transport(line)->takeReceived(), now);
        while (link_.session(line) == &session) {
          const auto event = session.nextEvent();
          if (!event) break;
          handle(*event, session, now);
        }
      });
    send();
  });
}

void LoadClient::handle(const core::SessionEvent& event, core::Session& session, core::TimePoint now) {
  if (std::holds_alternative<core::ModelOpened>(event)) {
    link_.succeeded();
    return sendWishes();
  }
  if (const auto* blob = std::get_if<core::BlobArrived>(&event)) return arrived(*blob, session, now);
  if (const auto* refused = std::get_if<core::BlobRefused>(&event)) {
    ++tally_.failed_wishes;
    pending_.erase(refused->blob.number);
    noteError("the server cannot give a blob: " + refused->message);
  }
  if (const auto* leaving = std::get_if<core::ServerLeaving>(&event)) {
    ++tally_.moved;
    link_.leave(leaving->reason, now);
  }
}

void LoadClient::arrived(const core::BlobArrived& blob, core::Session& session, core::TimePoint now) {
  ++tally_.blobs;
  tally_.bytes += blob.bytes.size();
  const auto found = pending_.find(blob.blob.number);
  if (found != pending_.end()) {
    const Pending pending = found->second;
    pending_.erase(found);
    if (plan_.decode && plan_.trace.wishes[pending.traced].decode) {
      core::DecodeJob job = *plan_.trace.wishes[pending.traced].decode;
      job.bytes = blob.bytes;
      const core::DecodeResult result = core::runDecodeJob(job);
      if (!result.failure.empty())
        throw Error(ErrorCode::kFormat, "a blob cannot be decoded: " + result.failure);
    }
    tally_.latency[static_cast<size_t>(pending.wish.wish_class)].add(now - pending.intended);
    const size_t open = session.openWishes();
    if (open < kRefillBelow && open < pending_.size()) sendWishes();
  }
  if (blob.blob.number == first_rung_ && !image_seen_) {
    image_seen_ = true;
    tally_.first_image.add(now - start_);
  } else if (first_rung_ == 0) {
    const HierarchyPage page =
        decodePage(blob.bytes, kRootKey, true);  // the root's page comes before all others
    const BlobRef& coarsest = page.nodes.front().rungs.back().payload;
    first_rung_ = coarsest.number;
    if (coarsest) session.expectUnasked(coarsest, {});
  }
}

void LoadClient::finish(core::TimePoint now) {
  if (gone_) return;
  for (const auto& [number, pending] : pending_) {
    if (pending.intended > now) continue;
    ++tally_.unanswered;
    tally_.latency[static_cast<size_t>(pending.wish.wish_class)].add(now - pending.intended);
  }
}

}  // namespace lode::app
