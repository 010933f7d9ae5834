#include "client/core/session/session.h"

#include <algorithm>
#include <utility>

#include "common/error.h"
#include "common/limits.h"
#include "proto/limits.h"

namespace lode::core {
namespace {

constexpr uint32_t kHelloCall = 1, kSecondCall = 2;
constexpr size_t kCompactBytes = 64u << 10;
// Each credit grant adds at least 1/8 of the window: large enough to keep grants few, small enough that the
// server need not wait.
constexpr uint64_t kGrantsPerWindow = 8;

void require(bool allowed, const std::string& what) {
  if (!allowed) throw Error(ErrorCode::kProtocol, "the server violated the protocol: " + what);
}

}  // namespace

Session::Session(SessionOptions options, TimePoint now)
    : options_(std::move(options)),
      granted_bytes_(proto::kInitialWindowBytes),
      sent_grant_bytes_(proto::kInitialWindowBytes),
      now_(now),
      last_sent_(now),
      last_ping_(now) {
  proto::Hello hello;
  hello.min_version = hello.max_version = proto::kProtocolVersion;
  hello.token = options_.token;
  hello.program = options_.program;
  send(proto::encode(hello, kHelloCall));
  if (options_.model.empty()) {
    send(proto::encode(proto::List{}, kSecondCall));
  } else {
    send(proto::encode(proto::Open{options_.model, options_.known_build_id}, kSecondCall));
  }
  next_call_ = kSecondCall + 1;
}

void Session::send(const proto::Bytes& frame) {
  outgoing_.insert(outgoing_.end(), frame.begin(), frame.end());
}

proto::Bytes Session::takeOutgoing() {
  sent_grant_bytes_ = granted_bytes_;
  if (!outgoing_.empty()) last_sent_ = now_;
  answer_bytes_ = 0;
  blocked_ = {};
  return std::exchange(outgoing_, {});
}

void Session::receive(std::span<const std::byte> bytes, TimePoint now) {
  advance(now);
  if (bytes.empty()) return;
  silence_ = {};
  received_bytes_ += bytes.size();
  if (awaitsBlobs()) window_.receive(bytes.size(), now);
  if (input_begin_ == input_.size()) {
    input_.clear();
    input_begin_ = 0;
  } else if (input_begin_ > kCompactBytes) {
    input_.erase(input_.begin(), input_.begin() + static_cast<ptrdiff_t>(input_begin_));
    input_begin_ = 0;
  }
  input_.insert(input_.end(), bytes.begin(), bytes.end());
}

std::optional<SessionEvent> Session::nextEvent() {
  while (!event_ && !hasUnsentAnswers() && takeFrame()) {
  }
  paused_ = hasUnsentAnswers();
  if (!event_ && !paused_) grantCredit();
  return std::exchange(event_, std::nullopt);
}

/// Parses a frame header. If the first header is invalid, reports that the other side is not a Lodestream
/// server.
proto::FrameHeader Session::headerOf(std::span<const std::byte, proto::kFrameHeaderBytes> bytes) const {
  try {
    return proto::decodeFrameHeader(bytes);
  } catch (const Error&) {
    if (state_ != State::kWelcome) throw;
    throw Error(ErrorCode::kProtocol, "the program at this address is not lodestreamd; check the port");
  }
}

bool Session::takeFrame() {
  const std::span<const std::byte> input = std::span(input_).subspan(input_begin_);
  if (input.size() < proto::kFrameHeaderBytes) return false;
  const proto::FrameHeader header = headerOf(input.first<proto::kFrameHeaderBytes>());
  if (input.size() - proto::kFrameHeaderBytes < header.body_bytes) return false;
  input_begin_ += proto::kFrameHeaderBytes + header.body_bytes;
  handleFrame(header, input.subspan(proto::kFrameHeaderBytes, header.body_bytes));
  return true;
}

void Session::handleFrame(const proto::FrameHeader& header, std::span<const std::byte> body) {
  switch (static_cast<proto::FrameType>(header.type)) {
    case proto::FrameType::kWelcome:
      return handleWelcome(header, body);
    case proto::FrameType::kOpened:
      return handleOpened(header, body);
    case proto::FrameType::kModels:
      return handleModels(header, body);
    case proto::FrameType::kBlob:
      return handleBlob(body);
    case proto::FrameType::kCancelled:
      return handleCancelled(body);
    case proto::FrameType::kError:
      return handleError(body);
    case proto::FrameType::kPong:
      return handlePong(body);
    case proto::FrameType::kPing:
      return handlePing(header, body);
    case proto::FrameType::kGoAway:
      event_ = ServerLeaving{"the server is shutting down (" + proto::decode<proto::GoAway>(body).reason +
                             "); try again later"};
      return;
    case proto::FrameType::kModelReplaced:
      require(state_ == State::kOpen && proto::decode<proto::ModelReplaced>(body).handle == handle_,
              "ModelReplaced for a model that is not open");
      event_ = ModelChanged{};
      return;
    default:
      require((header.flags & proto::kFlagOptional) != 0,
              "frame type " + std::to_string(header.type) + " is not sent to clients");
  }
}

void Session::handleWelcome(const proto::FrameHeader& header, std::span<const std::byte> body) {
  require(state_ == State::kWelcome && header.call == kHelloCall, "unexpected Welcome");
  const auto welcome = proto::decode<proto::Welcome>(body);
  require(welcome.version == proto::kProtocolVersion, "it chose version " + std::to_string(welcome.version));
  require(welcome.max_open_requests > 0, "it allows no requests");
  max_open_requests_ = std::min({welcome.max_open_requests, proto::kMaxOpenRequests, kMaxRequestsAtOnce});
  state_ = State::kAnswer;
}

void Session::handleOpened(const proto::FrameHeader& header, std::span<const std::byte> body) {
  require(state_ == State::kAnswer && !options_.model.empty() && header.call == kSecondCall,
          "unexpected Opened");
  auto opened = proto::decode<proto::Opened>(body);
  require(opened.summary.name == options_.model, "it opened another model than '" + options_.model + "'");
  const BlobRef& root_page = opened.summary.root_page;
  require(root_page && root_page.bytes > 0 && root_page.bytes <= kMaxPageBytes,
          "the model's first page has " + std::to_string(root_page.bytes) + " bytes");
  handle_ = opened.handle;
  state_ = State::kOpen;
  const Digest& known = options_.known_build_id;
  gives_first_blobs_ = known == Digest() || known != opened.summary.build_id;
  if (gives_first_blobs_) expectUnasked(root_page, {BlobKind::kRootPage, {kRootKey, 0}});
  sendPing();
  event_ = ModelOpened{std::move(opened.summary)};
}

void Session::handleModels(const proto::FrameHeader& header, std::span<const std::byte> body) {
  require(state_ == State::kAnswer && options_.model.empty() && header.call == kSecondCall,
          "unexpected list of models");
  state_ = State::kListed;
  event_ = ModelsListed{proto::decode<proto::Models>(body).models};
}

void Session::expectUnasked(const BlobRef& blob, const BlobUse& use) { unasked_ = Incoming{blob, use}; }

void Session::handleBlob(std::span<const std::byte> body) {
  const proto::BlobChunk chunk = proto::decodeBlobChunk(body);
  credited_bytes_ += body.size();
  require(credited_bytes_ <= sent_grant_bytes_, "it sent more bytes than the granted credit");
  const uint32_t request = chunk.header.request;
  if (request == 0) {
    require(unasked_.has_value(), "a blob that was not requested");
    appendChunk(*unasked_, chunk);
    if (unasked_->received_bytes == unasked_->blob.bytes)
      event_ = completed(*std::exchange(unasked_, std::nullopt));
  } else {
    const auto found = requests_.find(request);
    require(found != requests_.end(), "a blob that was not requested");
    OpenRequest& open = found->second;
    const size_t before = open.incoming.bytes.size();
    appendChunk(open.incoming, chunk);
    if (open.cancelling) cancelled_bytes_ += open.incoming.bytes.size() - before;
    if (open.incoming.received_bytes == open.incoming.blob.bytes) {
      Incoming whole = endRequest(request);
      event_ = whole.is_dropped ? SessionEvent(RequestCancelled{whole.blob}) : completed(std::move(whole));
    } else if (open.cancelling) {
      limitCancelledBytes(open);
    }
  }
  if (!awaitsBlobs()) window_.pause();
}

void Session::appendChunk(Incoming& incoming, const proto::BlobChunk& chunk) {
  require(chunk.header.total_bytes == incoming.blob.bytes,
          "blob " + std::to_string(incoming.blob.number) + " has another size than announced");
  require(chunk.header.offset_bytes == incoming.received_bytes,
          "a chunk of blob " + std::to_string(incoming.blob.number) + " out of order");
  incoming.received_bytes += static_cast<uint32_t>(chunk.bytes.size());
  if (incoming.is_dropped) return;
  if (incoming.bytes.empty()) incoming.bytes.reserve(incoming.blob.bytes);
  incoming.bytes.insert(incoming.bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
}

SessionEvent Session::completed(Incoming incoming) {
  const bool matches = options_.matches_digest ? options_.matches_digest(incoming.blob, incoming.bytes)
                                               : digestOf(incoming.bytes) == incoming.blob.digest;
  require(matches, "blob " + std::to_string(incoming.blob.number) + " does not match its digest");
  return BlobArrived{incoming.blob, incoming.use, std::move(incoming.bytes)};
}

void Session::handleCancelled(std::span<const std::byte> body) {
  const uint32_t request = proto::decode<proto::Cancelled>(body).request;
  const auto found = requests_.find(request);
  require(found != requests_.end() && found->second.cancelling,
          "Cancelled for a request that was not cancelled");
  event_ = RequestCancelled{found->second.incoming.blob};
  endRequest(request);
}

void Session::handleError(std::span<const std::byte> body) {
  const auto error = proto::decode<proto::ErrorMessage>(body);
  if (error.request == 0) {
    const bool is_of_the_coarsest = unasked_ && unasked_->use.kind == BlobKind::kMesh;
    const bool is_lost = is_of_the_coarsest && error.code == proto::WireError::kDamagedStore;
    const bool may_pass =
        error.code == proto::WireError::kInternal || error.code == proto::WireError::kNotReady;
    if (error.closes || !(is_lost || (unasked_ && may_pass))) return handleRefusal(error);
    const Incoming refused = *std::exchange(unasked_, std::nullopt);
    gives_first_blobs_ = false;  // the server sends nothing more without a request
    event_ = BlobRefused{refused.blob, refused.use, error.message, is_lost};
    return;
  }
  const auto found = requests_.find(error.request);
  require(found != requests_.end(), "an error for a request that is not open");
  const Incoming& incoming = found->second.incoming;
  const bool is_lost =
      error.code == proto::WireError::kDamagedStore || error.code == proto::WireError::kNoSuchBlob;
  event_ = BlobRefused{incoming.blob, incoming.use, error.message, is_lost};
  endRequest(error.request);
}

/// Handles an Error frame that refuses the session or the model.
void Session::handleRefusal(const proto::ErrorMessage& error) {
  const std::string message = "the server says: " + error.message;
  switch (error.code) {
    case proto::WireError::kLimit:
    case proto::WireError::kNotReady:
      event_ = ServerLeaving{message};
      return;
    case proto::WireError::kInternal:
      throw Error(ErrorCode::kNetwork, message);
    case proto::WireError::kNoSuchModel:
      if (!options_.awaits_model) throw Error(ErrorCode::kInput, message, Remedy::kModel);
      event_ = ServerLeaving{message, Remedy::kModel};
      return;
    case proto::WireError::kUnauthorized:
      throw Error(ErrorCode::kInput, message, Remedy::kToken);
    default:
      throw Error(ErrorCode::kInput, message);
  }
}

/// Returns how many bytes of an incomplete frame have been received.
uint64_t Session::bytesOfUnfinishedFrame() const { return input_.size() - input_begin_; }

/// Grants more bytes to the server. Counts the received part of an incomplete frame too, so that the server
/// can send the next chunk before the current one is complete.
void Session::grantCredit() {
  if (state_ == State::kWelcome) return;
  const uint64_t window_bytes = window_.bytes();
  const uint64_t grant_bytes = credited_bytes_ + bytesOfUnfinishedFrame() + window_bytes;
  if (grant_bytes < granted_bytes_ + window_bytes / kGrantsPerWindow) return;
  granted_bytes_ = grant_bytes;
  sendCredit();
}

void Session::sendCredit() { send(proto::encode(proto::Credit{granted_bytes_}, next_call_++)); }

void Session::sendPing() {
  last_ping_ = now_;
  ping_open_ = true;
  send(proto::encode(proto::Ping{++pings_}, next_call_++));
}

void Session::handlePing(const proto::FrameHeader& header, std::span<const std::byte> body) {
  const proto::Bytes pong = proto::encode(proto::Pong{proto::decode<proto::Ping>(body).payload}, header.call);
  answer_bytes_ += pong.size();
  send(pong);
}

void Session::handlePong(std::span<const std::byte> body) {
  require(ping_open_ && proto::decode<proto::Pong>(body).payload == pings_, "Pong without Ping");
  ping_open_ = false;
  window_.measureTrip(now_ - last_ping_);
}

void Session::tick(TimePoint now) {
  advance(now);
  if (silence_ >= kSilenceLimit)
    throw Error(ErrorCode::kTimeout, "the server has sent nothing for " +
                                         std::to_string(kSilenceLimit.count()) +
                                         " seconds: check the network and the server, then try again");
  if (blocked_ >= kSilenceLimit)
    throw Error(ErrorCode::kTimeout, "the server sends, but has read nothing for " +
                                         std::to_string(kSilenceLimit.count()) +
                                         " seconds: check the server, then try again");
  if (state_ == State::kWelcome) return;
  if (!ping_open_ &&
      (silence_ >= kPingInterval || (!requests_.empty() && now - last_ping_ >= kMeasureInterval)))
    sendPing();
  // On a slow link, a client may receive for minutes without sending anything. The server would then time
  // out, so send a credit.
  if (outgoing_.empty() && now - last_sent_ >= kPingInterval) sendCredit();
}

void Session::advance(TimePoint now) {
  const auto gap = std::min<std::chrono::nanoseconds>(now - now_, kMaxGap);
  (paused_ ? blocked_ : silence_) += gap;
  now_ = now;
}

}  // namespace lode::core
