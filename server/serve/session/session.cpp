#include "server/serve/session/session.h"

#include <algorithm>

#include "common/error.h"

namespace lode::serve {

using proto::FrameType;
using proto::WireError;

namespace {

/// Size of queued answers up to which a session without free memory refuses single requests. Above this size,
/// a refusal that exceeds the memory limits closes the connection.
constexpr size_t kRefusedAnswerBytes = 4u << 10;

/// Exception that the handler of a frame throws. The session then sends an Error that closes the connection.
struct Refusal {
  WireError code;
  std::string why;
};

WireError wireCode(const Error& error) {
  return error.code() == ErrorCode::kLimit ? WireError::kLimit : WireError::kMalformed;
}

}  // namespace

Session::Session(SessionHost host, SessionLimits limits, Clock::time_point now)
    : host_(host), limits_(limits), deadline_(now + limits.handshake), now_(now) {}

Session::~Session() {
  host_.memory->give(requests_.size() * kRequestBytes + opened_.size() * kOpenModelBytes + control_.size());
}

/// Queues a small frame, even if the budget is used up.
template <typename Message>
void Session::queueUnchecked(const Message& message, uint32_t call) {
  const proto::Bytes frame = proto::encode(message, call);
  control_.insert(control_.end(), frame.begin(), frame.end());
  host_.memory->take(frame.size());
}

template <typename Message>
void Session::queue(const Message& message, uint32_t call) {
  const proto::Bytes frame = proto::encode(message, call);
  if (!host_.memory->tryTake(frame.size())) {
    host_.memory->give(control_.size());
    control_.clear();
    throw Refusal{
        WireError::kLimit,
        "the server is short of memory for this connection; read answers sooner, and request less at a "
        "time"};
  }
  control_.insert(control_.end(), frame.begin(), frame.end());
}

void Session::refuse(WireError code, const std::string& why, uint32_t call) {
  if (closing_) return;
  queueUnchecked(proto::ErrorMessage{code, 0, true, why}, call);
  closing_ = true;
  refusal_ = why;
  host_.memory->give(requests_.size() * kRequestBytes);
  requests_.clear();
  unasked_.clear();
  under_way_.reset();
}

void Session::drain(const std::string& reason, Clock::time_point now) {
  if (closing_ || draining_) return;
  draining_ = true;
  queueUnchecked(proto::GoAway{reason}, 0);
  if (!greeted_) return;
  queueUnchecked(proto::Ping{}, 0);
  pong_deadline_ = now + proto::kHearDeadline;
}

bool Session::stopWaitingForPong(Clock::time_point now) noexcept {
  if (!pong_deadline_ || now < *pong_deadline_) return false;
  pong_deadline_.reset();
  return true;
}

bool Session::authorize() {
  if (!host_.served->tokens) return true;
  tokens_ = host_.served->tokens;
  grant_ = tokens_->find(token_, std::chrono::system_clock::now());
  unauthorized_ = grant_ == nullptr;
  return !unauthorized_;
}

bool Session::allows(const Model& model) const noexcept {
  return grant_ == nullptr || grant_->allows(model.summary.name);
}

void Session::servedSetChanged() {
  if (closing_) return;
  if (greeted_ && !authorize()) return refuse(WireError::kUnauthorized, "the token is no longer valid");
  for (auto& [handle, opened] : opened_) {
    const auto now = host_.served->catalog->find(opened.model->summary.name);
    if (!now || now->summary.build_id == opened.announced) continue;
    opened.announced = now->summary.build_id;
    queueUnchecked(proto::ModelReplaced{handle}, 0);
  }
}

void Session::checkExpiry(std::chrono::system_clock::time_point now) {
  if (closing_ || grant_ == nullptr || !grant_->hasExpired(now)) return;
  unauthorized_ = true;
  refuse(WireError::kUnauthorized, "the token has expired");
}

void Session::receive(const proto::FrameHeader& header, std::span<const std::byte> body,
                      Clock::time_point now) {
  if (closing_) return;
  now_ = now;
  try {
    dispatch(header, body);
    const bool known = proto::isFrameType(header.type);
    if (greeted_ && known) deadline_ = now + limits_.idle;
  } catch (const Error& error) {
    refuse(wireCode(error), std::string(proto::frameName(header.type)) + " frame: " + error.what(),
           header.call);
  } catch (const Refusal& refusal) {
    refuse(refusal.code, refusal.why, header.call);
  }
}

void Session::dispatch(const proto::FrameHeader& header, std::span<const std::byte> body) {
  const auto type = static_cast<FrameType>(header.type);
  const bool known = proto::isFrameType(header.type);
  if (!known && (header.flags & proto::kFlagOptional) != 0) return;
  if (!known)
    throw Refusal{WireError::kUnknownFrame, "frame type " + std::to_string(header.type) +
                                                " is unknown to this server, which speaks version " +
                                                std::to_string(proto::kProtocolVersion)};
  if (!greeted_ && type != FrameType::kHello)
    throw Refusal{WireError::kMalformed,
                  "a " + std::string(proto::frameName(header.type)) + " frame came before Hello"};
  switch (type) {
    case FrameType::kHello:
      return hello(proto::decode<proto::Hello>(body), header.call);
    case FrameType::kList:
      proto::decode<proto::List>(body);
      return list(header.call);
    case FrameType::kOpen:
      return open(proto::decode<proto::Open>(body), header.call);
    case FrameType::kClose:
      return close(proto::decode<proto::Close>(body), header.call);
    case FrameType::kRequests:
      return requests(body, header.call);
    case FrameType::kCredit:
      granted_bytes_ = std::max(granted_bytes_, proto::decode<proto::Credit>(body).granted_bytes);
      return;
    case FrameType::kPing:
      return queue(proto::Pong{proto::decode<proto::Ping>(body).payload}, header.call);
    case FrameType::kPong:
      proto::decode<proto::Pong>(body);
      pong_deadline_.reset();
      return;
    default:
      throw Refusal{WireError::kMalformed,
                    "a " + std::string(proto::frameName(header.type)) + " frame is not for a server"};
  }
}

void Session::hello(const proto::Hello& message, uint32_t call) {
  if (greeted_) throw Refusal{WireError::kMalformed, "a second Hello"};
  if (message.min_version > proto::kProtocolVersion)
    throw Refusal{WireError::kVersion,
                  "this server speaks version " + std::to_string(proto::kProtocolVersion) +
                      " of the protocol, the client " + std::to_string(message.min_version) +
                      " or newer; update the server"};
  if (message.max_version < proto::kProtocolVersion)
    throw Refusal{WireError::kVersion, "this server speaks version " +
                                           std::to_string(proto::kProtocolVersion) +
                                           " of the protocol, the client none above " +
                                           std::to_string(message.max_version) + "; update the client"};
  token_ = message.token;
  if (!authorize())
    throw Refusal{WireError::kUnauthorized, message.token.empty() ? "this server requires a token"
                                                                  : "the token is unknown or has expired"};
  greeted_ = true;
  queue(proto::Welcome{proto::kProtocolVersion, message.features & proto::kFeatureClose,
                       limits_.max_open_requests, "lodestreamd"},
        call);
}

void Session::list(uint32_t call) {
  proto::Models models;
  for (const auto& model : host_.served->catalog->models())
    if (allows(*model)) models.models.push_back(model->summary);
  queue(models, call);
}

void Session::open(const proto::Open& message, uint32_t call) {
  const auto refuse = [&](WireError code, std::string why) {
    queue(proto::ErrorMessage{code, 0, false, std::move(why)}, call);
  };
  std::shared_ptr<const Model> model = host_.served->catalog->find(message.model);
  if (!model || !allows(*model))
    return refuse(WireError::kNoSuchModel, "this server has no model '" + message.model + "'");
  if (opened_.size() >= limits_.max_open_models)
    return refuse(WireError::kLimit, "a connection has at most " + std::to_string(limits_.max_open_models) +
                                         " models open; close one, or open another connection");
  if (!host_.memory->tryTake(kOpenModelBytes))
    return refuse(WireError::kLimit, "the server is short of memory; close a model, or open this one later");
  const uint32_t handle = ++last_handle_;
  const Model& offered = *model;
  ModelCounters* const counters =
      host_.counters != nullptr ? &host_.counters->model(offered.summary.name) : nullptr;
  if (counters != nullptr) counters->opened.add();
  const Digest build = offered.summary.build_id;
  const OpenedModel& opened =
      opened_.emplace(handle, OpenedModel{std::move(model), build, counters}).first->second;
  queue(proto::Opened{handle, offered.summary}, call);
  if (build != Digest() && build == message.known_build_id)
    return;  // the client has the first blobs, or requests them itself
  for (const uint32_t blob : {offered.summary.root_page.number, offered.coarsest_blob})
    if (blob != 0)
      unasked_.push_back({handle, &opened, blob, 0, call, ++last_serial_, now_, held_.total(now_), false});
}

const OpenedModel& Session::openedAs(uint32_t handle, const char* frame) {
  const auto opened = opened_.find(handle);
  if (opened == opened_.end())
    throw Refusal{WireError::kMalformed,
                  std::string(frame) + " names handle " + std::to_string(handle) + ", which is not open"};
  return opened->second;
}

void Session::close(const proto::Close& message, uint32_t call) {
  openedAs(message.handle, "Close");
  requests_.endAll(message.handle, [&](OpenRequest& request) {
    queueUnchecked(proto::Cancelled{request.rank.request}, request.call);
    if (under_way_ && under_way_->request == request.rank.request) under_way_.reset();
    host_.memory->give(kRequestBytes);
  });
  if (under_way_ && under_way_->request == 0 && unasked_.front().handle == message.handle) under_way_.reset();
  std::erase_if(unasked_, [&](const Unasked& u) { return u.handle == message.handle; });
  opened_.erase(message.handle);
  host_.memory->give(kOpenModelBytes);
  queue(proto::Closed{message.handle}, call);
}

void Session::requests(std::span<const std::byte> body, uint32_t call) {
  thread_local proto::Requests message;  // reused by all sessions of the thread
  proto::decodeInto(body, message);
  const OpenedModel& opened = openedAs(message.handle, "Requests");
  for (const proto::RequestChange& change : message.changes) {
    if (change.action == proto::RequestAction::kAdd) {
      addRequest(change, message.handle, opened, call);
      continue;
    }
    OpenRequest* const request = requests_.find(change.request);
    if (request == nullptr) continue;  // the request ended before the change arrived
    if (change.action == proto::RequestAction::kCancel) {
      queue(proto::Cancelled{change.request}, request->call);
      endRequest(*request);
    } else {
      requests_.reprioritise(*request, change.request_class, change.priority_px);
    }
  }
}

void Session::addRequest(const proto::RequestChange& change, uint32_t handle, const OpenedModel& opened,
                         uint32_t call) {
  if (requests_.find(change.request) != nullptr)
    throw Refusal{WireError::kMalformed, "request " + std::to_string(change.request) + " is already open"};
  if (requests_.size() >= limits_.max_open_requests)
    throw Refusal{WireError::kLimit, "more than " + std::to_string(limits_.max_open_requests) +
                                         " requests are open at one time"};
  if (opened.model->blobBytes(change.blob) == 0) {
    queue(proto::ErrorMessage{WireError::kNoSuchBlob, change.request, false,
                              "the model has no blob " + std::to_string(change.blob)},
          call);
    return;
  }
  if (!host_.memory->tryTake(kRequestBytes)) {
    const proto::ErrorMessage refused{
        WireError::kNotReady, change.request, false,
        "the server is short of memory; request again later, and less at a time"};
    return control_.size() < kRefusedAnswerBytes ? queueUnchecked(refused, call) : queue(refused, call);
  }
  const Rank rank{change.request_class, change.priority_px, change.request};
  requests_.add(
      {rank, handle, &opened, change.blob, 0, call, false, ++last_serial_, now_, held_.total(now_)});
  if (host_.counters != nullptr) host_.counters->requests[static_cast<size_t>(change.request_class)].add();
}

void Session::endRequest(OpenRequest& request) {
  if (under_way_ && under_way_->request == request.rank.request) under_way_.reset();
  requests_.end(request);
  host_.memory->give(kRequestBytes);
}

/// Returns all unsent bytes of the most urgent blob as one chunk.
std::optional<Chunk> Session::next() {
  Chunk chunk;
  if (!unasked_.empty() && !unasked_.front().parked) {
    const Unasked& first = unasked_.front();
    chunk = {first.opened, first.blob,        0,
             first.call,   first.serial,      proto::RequestClass::kVisible,
             first.asked,  first.held_before, {0, 0, first.sent_bytes}};
  } else if (const OpenRequest* const first = requests_.first(); first != nullptr) {
    chunk = {first->opened, first->blob,        0,
             first->call,   first->serial,      first->rank.request_class,
             first->asked,  first->held_before, {first->rank.request, 0, first->sent_bytes}};
  } else {
    return {};
  }
  chunk.header.total_bytes = chunk.opened->model->blobBytes(chunk.blob);
  chunk.bytes = chunk.header.total_bytes - chunk.header.offset_bytes;
  return chunk;
}

uint64_t Session::window() const noexcept {
  const uint64_t used = sent_bytes_ + proto::kBlobChunkHeaderBytes;
  return granted_bytes_ > used ? granted_bytes_ - used : 0;
}

bool Session::waitsForWindow() {
  if (closing_) return false;
  const std::optional<Chunk> first = next();
  return first && window() < std::min(first->bytes, kMinChunkBytes);
}

std::optional<Chunk> Session::beginChunk(uint32_t max_bytes) {
  if (closing_ || !control_.empty() || under_way_) return {};
  std::optional<Chunk> chunk = next();
  if (!chunk) return {};
  const uint32_t rest = chunk->bytes;
  chunk->bytes =
      static_cast<uint32_t>(std::min<uint64_t>({rest, max_bytes, proto::kMaxChunkBytes, window()}));
  if (chunk->bytes < std::min(rest, kMinChunkBytes)) return {};
  under_way_ = UnderWay{chunk->header.request, chunk->bytes, chunk->bytes == rest};
  return chunk;
}

bool Session::finishChunk() {
  if (!under_way_) return false;
  const UnderWay done = *std::exchange(under_way_, {});
  sent_bytes_ += proto::kBlobChunkHeaderBytes + done.bytes;
  if (done.request == 0) {
    unasked_.front().sent_bytes += done.bytes;
    if (done.last) unasked_.pop_front();
  } else {
    OpenRequest& request = *requests_.find(done.request);
    request.sent_bytes += done.bytes;
    if (done.last) endRequest(request);
  }
  return true;
}

void Session::parkChunk() {
  if (!under_way_) return;
  const UnderWay parked = *std::exchange(under_way_, {});
  if (parked.request == 0)
    unasked_.front().parked = true;
  else
    requests_.park(*requests_.find(parked.request));
}

bool Session::unpark(const Chunk& chunk) {
  if (chunk.header.request == 0) {
    if (unasked_.empty() || unasked_.front().serial != chunk.serial) return false;
    unasked_.front().parked = false;
    return true;
  }
  OpenRequest* const request = requests_.find(chunk.header.request);
  if (request == nullptr || request->serial != chunk.serial) return false;
  requests_.unpark(*request);
  return true;
}

void Session::failChunk(WireError code, const std::string& why) {
  if (!under_way_) return;
  const UnderWay failed = *std::exchange(under_way_, {});
  if (failed.request == 0) {
    const Unasked first = unasked_.front();
    queueUnchecked(proto::ErrorMessage{code, 0, false, why}, first.call);
    std::erase_if(unasked_, [&](const Unasked& u) { return u.handle == first.handle; });
  } else {
    OpenRequest& request = *requests_.find(failed.request);
    queueUnchecked(proto::ErrorMessage{code, failed.request, false, why}, request.call);
    endRequest(request);
  }
}

}  // namespace lode::serve
