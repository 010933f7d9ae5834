#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/write.hpp>

#include "client/loadtest/request_watch.h"
#include "proto/limits.h"
#include "server/store/reader.h"

namespace lode::app {

/// A scripted server of one small store, on the clients' event loop.
class ToldServer {
 public:
  ToldServer(asio::io_context& io, const store::Reader& store) : store_(store), acceptor_(io, loopback()) {
    accept();
  }

  /// Sets whether requests stay open until grantAll(), or are answered at once.
  void holdBack(bool held) { holds_back_ = held; }
  /// Makes the next request end with an error.
  void refuseOne() { refuses_ = true; }
  /// Closes the next `count` connections without reading from them.
  void closeToTheNext(size_t count) { closed_to_ = count; }
  /// Answers all open requests of a connection.
  void grantAll(size_t connection) {
    for (const auto& [request, blob] : std::exchange(connections_[connection]->requests, {}))
      grant(*connections_[connection], request, blob);
  }
  size_t connections() const { return connections_.size(); }
  void saysNothing() { says_nothing_ = true; }
  /// Answers the next Hello with GoAway.
  void turnOneAway() { turns_away_ = true; }
  void goAway(size_t connection) { send(*connections_[connection], proto::GoAway{"maintenance"}, 0); }
  /// Sends the mesh of an open request and, in the same write, an Error that ends the connection.
  void grantAMeshAndFail(size_t connection) {
    Connection& to = *connections_[connection];
    const auto mesh =
        std::ranges::find_if(to.requests, [this](const auto& request) { return isMesh(request.second); });
    proto::Bytes frames = blobFrame(mesh->first, mesh->second);
    to.requests.erase(mesh);
    const proto::Bytes failure =
        proto::encode(proto::ErrorMessage{proto::WireError::kInternal, 0, false, "out of order"}, 0);
    frames.insert(frames.end(), failure.begin(), failure.end());
    asio::write(to.socket, asio::buffer(frames));
  }
  void breakOff(size_t connection) { connections_[connection]->socket.close(); }

  uint16_t port() const { return acceptor_.local_endpoint().port(); }
  /// Returns the number of times that a client has opened the model.
  size_t opened() const { return opened_; }
  /// Returns the number of answered requests.
  size_t granted() const { return granted_; }
  size_t openRequests(size_t connection) const {
    return connection < connections_.size() ? connections_[connection]->requests.size() : 0;
  }

 private:
  struct Connection {
    explicit Connection(asio::ip::tcp::socket accepted) : socket(std::move(accepted)) {}
    asio::ip::tcp::socket socket;
    std::vector<std::byte> buffer = std::vector<std::byte>(64u << 10), input;
    std::map<uint32_t, uint32_t> requests;  // blobs by request
    bool is_turned_away = false;
  };

  static asio::ip::tcp::endpoint loopback() { return {asio::ip::address_v4::loopback(), 0}; }

  void accept() {
    acceptor_.async_accept([this](asio::error_code error, asio::ip::tcp::socket socket) {
      if (error) return;
      if (closed_to_ > 0) {
        --closed_to_;
        return accept();
      }
      socket.set_option(asio::ip::tcp::no_delay(true));
      connections_.push_back(std::make_unique<Connection>(std::move(socket)));
      read(*connections_.back());
      accept();
    });
  }

  void read(Connection& from) {
    from.socket.async_read_some(
        asio::buffer(from.buffer), [this, &from](asio::error_code error, size_t count) {
          if (error) return;
          from.input.insert(from.input.end(), from.buffer.begin(),
                            from.buffer.begin() + static_cast<long>(count));
          const size_t taken = forEachFrame(
              from.input,
              [&](proto::FrameType type, std::span<const std::byte> body) { answer(from, type, body); });
          from.input.erase(from.input.begin(), from.input.begin() + static_cast<long>(taken));
          read(from);
        });
  }

  void answer(Connection& to, proto::FrameType type, std::span<const std::byte> body) {
    if (says_nothing_ || to.is_turned_away) return;
    if (type == proto::FrameType::kHello && std::exchange(turns_away_, false)) {
      to.is_turned_away = true;
      return send(to, proto::GoAway{"maintenance"}, 0);
    }
    if (type == proto::FrameType::kHello)
      send(to, proto::Welcome{proto::kProtocolVersion, 0, 16384, "test"}, 1);
    if (type == proto::FrameType::kOpen) open(to, proto::decode<proto::Open>(body).known_build_id);
    if (type == proto::FrameType::kPing) send(to, proto::Pong{proto::decode<proto::Ping>(body).payload}, 0);
    if (type != proto::FrameType::kRequests) return;
    for (const proto::RequestChange& change : proto::decode<proto::Requests>(body).changes) take(to, change);
  }

  void open(Connection& to, const Digest& known_build_id) {
    ++opened_;
    send(to, proto::Opened{1, store_.summary()}, 2);
    if (known_build_id == store_.summary().build_id) return;
    give(to, 0, store_.summary().root_page.number);
    give(to, 0, store_.find(kRootKey)->lods.back().payload.number);
  }

  void take(Connection& from, const proto::RequestChange& change) {
    if (change.action == proto::RequestAction::kCancel && from.requests.erase(change.request) > 0)
      send(from, proto::Cancelled{change.request}, 0);
    if (change.action != proto::RequestAction::kAdd) return;
    if (std::exchange(refuses_, false))
      send(from, proto::ErrorMessage{proto::WireError::kDamagedStore, change.request, false, "damaged"}, 0);
    else if (holds_back_)
      from.requests[change.request] = change.blob;
    else
      grant(from, change.request, change.blob);
  }

  void grant(Connection& to, uint32_t request, uint32_t blob) {
    ++granted_;
    give(to, request, blob);
  }

  void give(Connection& to, uint32_t request, uint32_t blob) {
    asio::write(to.socket, asio::buffer(blobFrame(request, blob)));
  }

  bool isMesh(uint32_t blob) const {
    return std::ranges::any_of(store_.nodes(), [&](const Node& node) {
      return std::ranges::any_of(node.lods, [&](const Lod& lod) { return lod.payload.number == blob; });
    });
  }

  proto::Bytes blobFrame(uint32_t request, uint32_t blob) const {
    const std::vector<std::byte> bytes = store_.readBlob(blob);
    const auto size = static_cast<uint32_t>(bytes.size());
    const auto fields = proto::encodeBlobChunkHeader({request, size, 0});
    const auto header = proto::encodeFrameHeader(
        {static_cast<uint32_t>(fields.size()) + size, static_cast<uint8_t>(proto::FrameType::kBlob), 0, 0});
    proto::Bytes frame(header.begin(), header.end());
    frame.insert(frame.end(), fields.begin(), fields.end());
    frame.insert(frame.end(), bytes.begin(), bytes.end());
    return frame;
  }

  template <typename Message>
  static void send(Connection& to, const Message& message, uint32_t call) {
    asio::write(to.socket, asio::buffer(proto::encode(message, call)));
  }

  const store::Reader& store_;
  asio::ip::tcp::acceptor acceptor_;
  std::vector<std::unique_ptr<Connection>> connections_;
  size_t opened_ = 0, granted_ = 0, closed_to_ = 0;
  bool holds_back_ = false, refuses_ = false, turns_away_ = false, says_nothing_ = false;
};

}  // namespace lode::app
