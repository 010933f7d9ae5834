#include "server/serve/session.h"

#include <algorithm>
#include <tuple>

#include "common/error.h"

namespace lode::serve {

using proto::FrameType;
using proto::WireError;

namespace {

/// Thrown by a handler to answer with an Error that closes the connection.
struct Refusal {
  WireError code;
  std::string why;
};

WireError wireCode(const Error& error) {
  return error.code() == ErrorCode::kLimit ? WireError::kLimit : WireError::kMalformed;
}

}  // namespace

bool Session::Rank::operator<(const Rank& other) const noexcept {
  return std::tuple(wish_class, -priority_px, wish) <
         std::tuple(other.wish_class, -other.priority_px, other.wish);
}

Session::Session(std::span<const OfferedModel> models, SessionLimits limits, Clock::time_point now)
    : models_(models), limits_(limits), deadline_(now + limits.handshake) {}

template <typename Message>
void Session::answer(const Message& message, uint32_t request) {
  const proto::Bytes frame = proto::encode(message, request);
  control_.insert(control_.end(), frame.begin(), frame.end());
}

void Session::refuse(WireError code, const std::string& why, uint32_t request) {
  if (closing_) return;
  answer(proto::ErrorMessage{code, 0, true, why}, request);
  closing_ = true;
  wishes_.clear();
  queue_.clear();
  unasked_.clear();
  under_way_.reset();
}

void Session::drain(const std::string& reason) {
  if (closing_ || draining_) return;
  draining_ = true;
  answer(proto::GoAway{reason}, 0);
}

void Session::receive(const proto::FrameHeader& header, std::span<const std::byte> body,
                      Clock::time_point now) {
  if (closing_) return;
  try {
    dispatch(header, body);
    if (greeted_) deadline_ = now + limits_.idle;
  } catch (const Error& error) {
    refuse(wireCode(error), std::string(proto::frameName(header.type)) + " frame: " + error.what(),
           header.request);
  } catch (const Refusal& refusal) {
    refuse(refusal.code, refusal.why, header.request);
  }
}

void Session::dispatch(const proto::FrameHeader& header, std::span<const std::byte> body) {
  const auto type = static_cast<FrameType>(header.type);
  const bool known = type >= FrameType::kHello && type <= FrameType::kPong;
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
      return hello(proto::decode<proto::Hello>(body), header.request);
    case FrameType::kList: {
      proto::decode<proto::List>(body);
      proto::Models models;
      for (const OfferedModel& model : models_) models.models.push_back(model.summary);
      return answer(models, header.request);
    }
    case FrameType::kOpen:
      return open(proto::decode<proto::Open>(body), header.request);
    case FrameType::kWishes:
      return wishes(proto::decode<proto::Wishes>(body), header.request);
    case FrameType::kCredit:
      granted_bytes_ = std::max(granted_bytes_, proto::decode<proto::Credit>(body).granted_bytes);
      return;
    case FrameType::kPing:
      return answer(proto::Pong{proto::decode<proto::Ping>(body).payload}, header.request);
    case FrameType::kPong:
      proto::decode<proto::Pong>(body);
      return;
    default:
      throw Refusal{WireError::kMalformed,
                    "a " + std::string(proto::frameName(header.type)) + " frame is not for a server"};
  }
}

void Session::hello(const proto::Hello& message, uint32_t request) {
  if (greeted_) throw Refusal{WireError::kMalformed, "a second Hello"};
  if (message.min_version > proto::kProtocolVersion)
    throw Refusal{WireError::kVersion,
                  "this server speaks version " + std::to_string(proto::kProtocolVersion) +
                      " of the protocol, the client " + std::to_string(message.min_version) +
                      " or newer; update the server"};
  greeted_ = true;
  answer(proto::Welcome{proto::kProtocolVersion, 0, limits_.max_open_wishes, "lodestreamd"}, request);
}

void Session::open(const proto::Open& message, uint32_t request) {
  const auto model = std::ranges::find(models_, message.model, [](const auto& m) { return m.summary.name; });
  if (model == models_.end()) {
    answer(proto::ErrorMessage{WireError::kNoSuchModel, 0, false,
                               "there is no model '" + message.model + "' here; List names those there are"},
           request);
    return;
  }
  if (opened_.size() >= proto::kMaxOpenModels) {
    answer(proto::ErrorMessage{WireError::kLimit, 0, false,
                               "a connection opens at most " + std::to_string(proto::kMaxOpenModels) +
                                   " models; open another connection"},
           request);
    return;
  }
  const auto index = static_cast<uint32_t>(model - models_.begin());
  opened_.push_back(index);
  const auto handle = static_cast<uint32_t>(opened_.size());
  answer(proto::Opened{handle, model->summary}, request);
  unasked_.push_back({handle, index, model->summary.root_page.number, 0, request});
  if (model->coarsest_blob != 0) unasked_.push_back({handle, index, model->coarsest_blob, 0, request});
}

void Session::wishes(const proto::Wishes& message, uint32_t request) {
  if (message.handle == 0 || message.handle > opened_.size())
    throw Refusal{WireError::kMalformed,
                  "Wishes name handle " + std::to_string(message.handle) + ", which no Opened gave"};
  const uint32_t model = opened_[message.handle - 1];
  for (const proto::WishChange& change : message.changes) {
    if (change.action == proto::WishAction::kAdd) {
      addWish(change, model, request);
      continue;
    }
    const auto wish = wishes_.find(change.wish);
    if (wish == wishes_.end()) continue;  // it ended while the change was on its way
    if (change.action == proto::WishAction::kCancel) {
      answer(proto::Cancelled{change.wish}, wish->second.request);
      endWish(wish);
    } else {
      queue_.erase(wish->second.rank);
      wish->second.rank = {change.wish_class, change.priority_px, change.wish};
      queue_.insert(wish->second.rank);
    }
  }
}

void Session::addWish(const proto::WishChange& change, uint32_t model, uint32_t request) {
  if (wishes_.contains(change.wish))
    throw Refusal{WireError::kMalformed, "wish " + std::to_string(change.wish) + " is open already"};
  if (wishes_.size() >= limits_.max_open_wishes)
    throw Refusal{WireError::kLimit,
                  "more than " + std::to_string(limits_.max_open_wishes) + " wishes are open at one time"};
  if (models_[model].blobBytes(change.blob) == 0) {
    answer(proto::ErrorMessage{WireError::kNoSuchBlob, change.wish, false,
                               "no blob " + std::to_string(change.blob)},
           request);
    return;
  }
  const Rank rank{change.wish_class, change.priority_px, change.wish};
  wishes_.emplace(change.wish, Wish{rank, model, change.blob, 0, request});
  queue_.insert(rank);
}

void Session::endWish(std::unordered_map<uint32_t, Wish>::iterator wish) {
  if (under_way_ && under_way_->wish == wish->first) under_way_.reset();
  queue_.erase(wish->second.rank);
  wishes_.erase(wish);
}

std::optional<Chunk> Session::beginChunk(uint32_t max_bytes) {
  if (closing_ || !control_.empty() || under_way_ || (unasked_.empty() && queue_.empty())) return {};
  const uint64_t room = granted_bytes_ > sent_bytes_ ? granted_bytes_ - sent_bytes_ : 0;
  if (room <= proto::kBlobChunkHeaderBytes) return {};

  Chunk chunk;
  uint32_t sent = 0;
  if (!unasked_.empty()) {
    const Unasked& first = unasked_.front();
    chunk = {first.model, first.blob, 0, first.request, {}};
    sent = first.sent_bytes;
  } else {
    const Wish& first = wishes_.at(queue_.begin()->wish);
    chunk = {first.model, first.blob, 0, first.request, {first.rank.wish, 0, 0}};
    sent = first.sent_bytes;
  }
  const uint32_t total = models_[chunk.model].blobBytes(chunk.blob);
  const uint32_t rest = total - sent;
  chunk.header.total_bytes = total;
  chunk.header.offset_bytes = sent;
  chunk.bytes = static_cast<uint32_t>(
      std::min<uint64_t>({rest, max_bytes, proto::kMaxChunkBytes, room - proto::kBlobChunkHeaderBytes}));
  if (chunk.bytes < rest && chunk.bytes < kMinChunkBytes) return {};
  under_way_ = UnderWay{chunk.header.wish, chunk.bytes, chunk.bytes == rest};
  return chunk;
}

bool Session::finishChunk() {
  if (!under_way_) return false;
  const UnderWay done = *std::exchange(under_way_, {});
  sent_bytes_ += proto::kBlobChunkHeaderBytes + done.bytes;
  if (done.wish == 0) {
    unasked_.front().sent_bytes += done.bytes;
    if (done.last) unasked_.pop_front();
  } else {
    const auto wish = wishes_.find(done.wish);
    wish->second.sent_bytes += done.bytes;
    if (done.last) endWish(wish);
  }
  return true;
}

void Session::failChunk(WireError code, const std::string& why) {
  if (!under_way_) return;
  const UnderWay failed = *std::exchange(under_way_, {});
  if (failed.wish == 0) {
    const Unasked first = unasked_.front();
    answer(proto::ErrorMessage{code, 0, false, why}, first.request);
    std::erase_if(unasked_, [&](const Unasked& u) { return u.handle == first.handle; });
  } else {
    const auto wish = wishes_.find(failed.wish);
    answer(proto::ErrorMessage{code, failed.wish, false, why}, wish->second.request);
    endWish(wish);
  }
}

}  // namespace lode::serve
