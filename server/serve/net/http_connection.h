#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <asio/awaitable.hpp>

#include "proto/byte_stream.h"
#include "server/http/request_head.h"
#include "server/http/response_head.h"
#include "server/serve/net/client_connection.h"
#include "server/serve/net/connection.h"
#include "server/serve/net/http_files.h"

namespace lode::serve {

/// A client's HTTP connection: one coroutine on the socket's thread that reads requests and answers them in
/// order. The coroutine keeps the connection alive. Not thread safe.
class HttpConnection : public ClientConnection, public std::enable_shared_from_this<HttpConnection> {
 public:
  /// @param client  the client's address, for the log.
  HttpConnection(proto::ByteStream stream, Slot slot, MemoryAccount memory, ConnectionHost& host,
                 ConnectionLimits limits, std::string client);
  ~HttpConnection() override;
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  void start();
  void drain(const std::string& reason) override;
  void servedSetChanged() override {}  // each request uses the current models and tokens
  void sweep(Clock::time_point now) override;
  void endForMemory() override;
  uint64_t heldBytes() const noexcept override { return memory_.held(); }

 private:
  /// A content, or the HTTP status that says why there is none.
  template <typename Kind>
  struct Obtained {
    std::shared_ptr<const Kind> content;
    int status = 200;
  };

  asio::awaitable<void> run();
  asio::awaitable<bool> greet();
  asio::awaitable<void> serveRequests();
  asio::awaitable<std::optional<http::ParsedHead>> readHead();
  bool isForThisServer(std::string_view host) const noexcept;
  asio::awaitable<bool> answer(const http::RequestHead& head);
  asio::awaitable<bool> answerAllowed(const http::RequestHead& head, const http::Route& route,
                                      const ServedSet& served, const TokenGrant* grant);
  asio::awaitable<bool> answerWebSocket(const http::RequestHead& head);
  asio::awaitable<bool> answerFile(const http::RequestHead& head, const http::Route& route,
                                   std::shared_ptr<const Model> model);
  asio::awaitable<bool> answerContent(const http::RequestHead& head, const http::Route& route,
                                      HttpContent wanted, bool is_private);
  asio::awaitable<bool> sendContent(const http::RequestHead& head, http::ResponseHead response,
                                    std::span<const std::byte> body);
  asio::awaitable<bool> refuseFile(const http::RequestHead& head, int status, const std::string& model);
  asio::awaitable<bool> refuseToken(const http::RequestHead& head, bool is_blocked);
  asio::awaitable<bool> refuse(const http::RequestHead& head, int status, std::string why,
                               bool closes = false);
  template <typename Kind>
  asio::awaitable<Obtained<Kind>> obtain(HttpContent wanted);
  asio::awaitable<void> send(http::ResponseHead response, std::span<const std::byte> body);
  asio::awaitable<size_t> waitForTurn(size_t bytes);
  asio::awaitable<void> linger();
  bool reserveForHead();
  uint64_t addressOfClient() const;
  void end(EndReason reason);

  Slot slot_;
  MemoryAccount memory_;
  ConnectionHost& host_;
  ConnectionLimits limits_;
  proto::ByteStream stream_;
  ByteRate rate_;
  std::string received_;  ///< received bytes of the next requests; size() is the size of the buffer
  size_t received_bytes_ = 0;
  bool draining_ = false;
  bool is_idle_ = true;        ///< no byte of the next request has arrived
  bool is_websocket_ = false;  ///< the stream was moved to a Connection
  bool is_too_many_ = false;   ///< the address that the balancer's header names has too many connections
  bool closes_ = false;        ///< the connection ends after the current response
  /// Time by which the head of the next request must be complete, or its first byte must arrive.
  std::optional<Clock::time_point> head_deadline_;
  std::optional<Clock::time_point> writing_since_;  ///< start of the current write; empty between writes
  std::optional<Clock::time_point> linger_until_;
  std::optional<EndReason> end_;
  std::string why_;  ///< reason of a refusal, for the log
  std::string client_;
  Clock::time_point began_ = Clock::now();
  uint64_t requests_ = 0, sent_bytes_ = 0;  ///< totals of this connection
};

}  // namespace lode::serve
