#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/core/session/session.h"
#include "common/codec/hierarchy_page.h"
#include "proto/limits.h"
#include "tests/unit/core/session_fixture.h"
#include "tests/unit/core/synthetic_model.h"

namespace lode::core::fixture {

/// The server side of the protocol for one synthetic model, without a socket: takes and returns frames.
/// Payloads are placeholder bytes of the announced size; the model provides the meshes.
class ScriptedServer {
 public:
  explicit ScriptedServer(const SyntheticModel& model) { serve(model); }

  /// Replaces the model by another build: notifies clients of the old one and stops serving it.
  void replaceBy(const SyntheticModel& model) {
    open_.clear();
    nodes_.clear();
    blobs_.clear();
    serve(model);
    if (!opened_) return;
    deaf_ = true;
    append(proto::encode(proto::ModelReplaced{1}, 0));
  }

 private:
  void serve(const SyntheticModel& model) {
    for (const auto& [key, node] : model.nodes()) nodes_.emplace(key, node);
    for (auto& [key, node] : nodes_)
      for (Lod& lod : node.lods)
        if (lod.payload)
          lod.payload = keep(lod.payload.number, blobBytes(lod.payload.number, lod.payload.bytes));
    for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node)  // deepest first
      if (node->second.child_page)
        node->second.child_page =
            keep(node->second.child_page.number, encodePage({collect(node->first, 1, 2)}));
    summary_.name = "model";
    summary_.lattice = SyntheticModel::lattice();
    summary_.attributes = SyntheticModel::attributes();
    summary_.box = nodes_.at(kRootKey).box;
    summary_.nodes = nodes_.size();
    summary_.root_page = keep(kRootPageBlob, encodePage({collect(kRootKey, 0, 2)}));
    summary_.build_id = summary_.root_page.digest;
  }

 public:
  /// Starts a new connection and drops the state of the last one.
  void accept() {
    open_.clear();
    answers_.clear();
    granted_ = proto::kInitialWindowBytes;
    sent_ = 0;
    deaf_ = opened_ = false;
  }

  /// Sets whether the model exists for clients that open it later.
  void offer(bool is_there) { has_model_ = is_there; }

  /// Takes complete frames.
  void receive(const Bytes& bytes) {
    if (deaf_) return;
    for (const SentFrame& frame : framesOf(bytes)) {
      switch (static_cast<FrameType>(frame.header.type)) {
        case FrameType::kHello:
          append(welcome());
          break;
        case FrameType::kOpen:
          answerOpen(proto::decode<proto::Open>(frame.body).known_build_id);
          break;
        case FrameType::kRequests:
          for (const auto& change : proto::decode<proto::Requests>(frame.body).changes) take(change);
          break;
        case FrameType::kCredit:
          granted_ = std::max(granted_, proto::decode<proto::Credit>(frame.body).granted_bytes);
          break;
        case FrameType::kPing:
          append(proto::encode(proto::Pong{proto::decode<proto::Ping>(frame.body).payload}, 0));
          break;
        default:
          break;
      }
    }
  }

  /// Returns complete frames: replies, then a limited number of blob chunks, best first.
  Bytes give(size_t max_chunks) {
    for (; max_chunks > 0 && !open_.empty(); --max_chunks) {
      auto best = open_.begin();
      for (auto request = open_.begin(); request != open_.end(); ++request)
        if (request->second.before(best->second)) best = request;
      if (!sendChunk(best->first, best->second)) break;
      if (best->second.sent_bytes < blobs_.at(best->second.blob).size()) continue;
      ++completed_[best->second.blob];
      open_.erase(best);
    }
    return std::exchange(answers_, {});
  }

  const std::map<NodeKey, Node>& nodes() const { return nodes_; }
  const ModelSummary& summary() const { return summary_; }
  /// Number of requests that delivered a blob.
  const std::map<uint32_t, unsigned>& completed() const { return completed_; }
  size_t openRequests() const { return open_.size(); }

 private:
  static constexpr uint32_t kRootPageBlob = 1u << 30;

  struct OpenRequest {
    uint32_t blob = 0;
    proto::RequestClass request_class = proto::RequestClass::kVisible;
    float priority_px = 0;
    size_t sent_bytes = 0;
    bool before(const OpenRequest& other) const {
      if (request_class != other.request_class) return request_class < other.request_class;
      return priority_px > other.priority_px;
    }
  };

  BlobRef keep(uint32_t number, Bytes bytes) {
    const BlobRef ref{number, static_cast<uint32_t>(bytes.size()), digestOf(bytes)};
    blobs_[number] = std::move(bytes);
    return ref;
  }

  void append(const Bytes& bytes) { answers_.insert(answers_.end(), bytes.begin(), bytes.end()); }

  void answerOpen(const Digest& known_build_id) {
    if (!has_model_)
      return append(
          proto::encode(proto::ErrorMessage{proto::WireError::kNoSuchModel, 0, false, "no model"}, 2));
    opened_ = true;
    proto::Opened message;
    message.handle = 1;
    message.summary = summary_;
    append(proto::encode(message, 2));
    if (known_build_id == summary_.build_id) return;
    sendUnasked(kRootPageBlob);
    sendUnasked(nodes_.at(kRootKey).lods.back().payload.number);
  }

  void sendUnasked(uint32_t blob) {
    const Bytes& bytes = blobs_.at(blob);
    for (size_t at = 0; at < bytes.size(); at += proto::kMaxChunkBytes) sendPiece(0, bytes, at);
  }

  size_t sendPiece(uint32_t request, const Bytes& bytes, size_t at) {
    const size_t size = std::min<size_t>(proto::kMaxChunkBytes, bytes.size() - at);
    append(chunkFrame(request, static_cast<uint32_t>(bytes.size()), static_cast<uint32_t>(at),
                      std::span(bytes).subspan(at, size)));
    sent_ += size + proto::kBlobChunkHeaderBytes;
    return size;
  }

  bool sendChunk(uint32_t number, OpenRequest& request) {
    const Bytes& bytes = blobs_.at(request.blob);
    if (sent_ + proto::kMaxChunkBytes + proto::kBlobChunkHeaderBytes > granted_) return false;
    request.sent_bytes += sendPiece(number, bytes, request.sent_bytes);
    return true;
  }

  void take(const proto::RequestChange& change) {
    const auto open = open_.find(change.request);
    if (change.action == proto::RequestAction::kAdd) {
      open_[change.request] = {change.blob, change.request_class, change.priority_px, 0};
    } else if (open != open_.end() && change.action == proto::RequestAction::kCancel) {
      open_.erase(open);
      append(proto::encode(proto::Cancelled{change.request}, 0));
    } else if (open != open_.end()) {
      open->second.request_class = change.request_class;
      open->second.priority_px = change.priority_px;
    }
  }

  std::vector<Node> collect(NodeKey owner, int from_level, int to_level) const {
    std::vector<Node> found;
    for (const auto& [key, node] : nodes_) {
      const int level = key.depth() - owner.depth();
      if (level >= from_level && level <= to_level && owner.contains(key)) found.push_back(node);
    }
    return found;
  }

  std::map<NodeKey, Node> nodes_;
  std::map<uint32_t, Bytes> blobs_;
  ModelSummary summary_;
  std::map<uint32_t, OpenRequest> open_;  // open requests by request number
  std::map<uint32_t, unsigned> completed_;
  Bytes answers_;
  bool opened_ = false;  // a client of this connection has opened the model
  bool has_model_ = true;
  bool deaf_ = false;  // ignores frames about a replaced model
  uint64_t granted_ = proto::kInitialWindowBytes, sent_ = 0;
};

}  // namespace lode::core::fixture
