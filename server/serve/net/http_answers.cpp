#include <array>
#include <memory>
#include <utility>

#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>

#include "server/http/conditions.h"
#include "server/http/content_type.h"
#include "server/serve/net/http_connection.h"

/// HttpConnection's part that answers: selects resources, checks tokens, and obtains contents.
namespace lode::serve {

namespace {

constexpr std::string_view kPlainText = "text/plain; charset=utf-8";
constexpr const char* kWrongHost =
    "this server answers only requests to localhost, 127.0.0.1 or [::1]; start it with --public or a token "
    "file to serve it under other names";

/// Result of a ContentMakers::make(), for the connection that waits for it.
struct Wait {
  explicit Wait(const asio::any_io_executor& executor) : timer(executor) {}

  asio::steady_timer timer;
  bool is_over = false;
  http::MakeResult result = http::MakeResult::kBusy;
  std::shared_ptr<const http::Content> content;
};

/// Status for MakeResult::kUnreadable; clients get kBusyStatus.
constexpr int kUnreadableStatus = 0;
constexpr int kDamagedStatus = 500, kBusyStatus = 503;

int statusOf(http::MakeResult result) noexcept {
  switch (result) {
    case http::MakeResult::kDone:
      return 200;
    case http::MakeResult::kUnreadable:
      return kUnreadableStatus;
    case http::MakeResult::kFailed:
      return kDamagedStatus;
    case http::MakeResult::kBusy:
      break;
  }
  return kBusyStatus;
}

std::string_view extraFieldsOf(int status) noexcept {
  if (status == 401) return http::kBearerField;
  if (status == 405) return http::kAllowField;
  if (status == 426) return http::kWebSocketField;
  if (status == 429 || status == 503) return http::kRetryField;
  return {};
}

}  // namespace

/// Answers a request. @return false if the connection must end.
asio::awaitable<bool> HttpConnection::answer(const http::RequestHead& head) {
  closes_ = draining_ || !head.keeps_alive;
  if (!isForThisServer(head.host)) co_return co_await refuse(head, 421, kWrongHost);
  if (head.method == http::Method::kOptions) {
    http::ResponseHead response{.status = 204};
    response.extra = http::kPreflightFields;
    co_await send(response, {});
    co_return !closes_;
  }
  if (head.method == http::Method::kOther) co_return co_await refuse(head, 405, "use GET, HEAD or OPTIONS");
  const http::Route route = http::parseTarget(head.target);
  if (route.resource == http::Resource::kMalformed)
    co_return co_await refuse(head, 400, "the path of the request is malformed");
  if (route.resource == http::Resource::kWebSocket) co_return co_await answerWebSocket(head);
  if (const page::PageFile* const file = host_.http->findPage(route))
    co_return co_await answerContent(head, route, host_.http->page(*file), false);
  const ServedSet served = host_.served;
  const TokenGrant* grant = nullptr;
  if (served.tokens) {
    std::optional<std::string_view> token = http::bearerToken(head.authorization);
    if (!token && route.token) token = *route.token;
    if (!token || token->empty()) co_return co_await refuse(head, 401, "this server requires a token");
    if (host_.wrong_tokens->blocks(addressOfClient(), Clock::now()))
      co_return co_await refuseToken(head, true);
    grant = served.tokens->find(*token, std::chrono::system_clock::now());
    if (grant == nullptr) co_return co_await refuseToken(head, false);
  }
  co_return co_await answerAllowed(head, route, served, grant);
}

/// Returns true if this server may answer requests to a host. A server that is neither public nor protected
/// by tokens answers only requests to this machine. Otherwise a page of another host could read the models
/// after its name resolves to 127.0.0.1 (DNS rebinding).
bool HttpConnection::isForThisServer(std::string_view host) const noexcept {
  return host_.is_public || host_.served.tokens || http::isLoopbackHost(host);
}

/// Answers a request whose token is valid. @param grant  rights of the token; null allows all models.
asio::awaitable<bool> HttpConnection::answerAllowed(const http::RequestHead& head, const http::Route& route,
                                                    const ServedSet& served, const TokenGrant* grant) {
  switch (route.resource) {
    case http::Resource::kIndex:
    case http::Resource::kModels:
      co_return co_await answerContent(
          head, route,
          host_.http->list(*served.catalog, grant, route.resource, http::isLoopbackHost(head.host)),
          served.tokens != nullptr);
    case http::Resource::kTileset:
    case http::Resource::kTilesetPage:
    case http::Resource::kTile:
    case http::Resource::kJpeg:
    case http::Resource::kWebp: {
      std::shared_ptr<const Model> model = served.catalog->find(route.model);
      if (!model || (grant != nullptr && !grant->allows(route.model)))
        co_return co_await refuse(head, 404, "this server has no such model");
      co_return co_await answerFile(head, route, std::move(model));
    }
    default:
      co_return co_await refuse(head, 404, "there is nothing at this path");
  }
}

/// Opens a WebSocket for the native protocol. Does not check the token, which the protocol's Hello carries.
/// Unless the server is public, refuses pages of other hosts, because browsers do not.
asio::awaitable<bool> HttpConnection::answerWebSocket(const http::RequestHead& head) {
  if (!head.websocket) co_return co_await refuse(head, 426, "open a WebSocket here");
  const http::WebSocketRequest& request = *head.websocket;
  if (head.method != http::Method::kGet || request.version != "13")
    co_return co_await refuse(head, 426, "use version 13 of the WebSocket protocol");
  if (!proto::isWebSocketKey(request.key) || received_bytes_ > 0)
    co_return co_await refuse(head, 400, "this is not a valid request for a WebSocket", true);
  if (!host_.is_public && !http::isSameOrigin(request.origin, head.host))
    co_return co_await refuse(head, 403, "pages of other hosts may not open WebSockets to this server");
  const std::string accept = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: " +
                             proto::webSocketAccept(request.key) + "\r\n";
  http::ResponseHead response{.status = 101};
  response.extra = accept;
  co_await send(response, {});
  stream_.startWebSocket();
  is_websocket_ = true;
  ConnectionLimits limits = limits_;
  limits.proxy_protocol = false;  // the balancer's header has been read
  const auto connection = std::make_shared<Connection>(std::move(stream_), std::move(slot_),
                                                       std::move(memory_), host_, limits, client_);
  connection->start();
  if (draining_) connection->drain("the server is stopping");
  co_return true;
}

asio::awaitable<bool> HttpConnection::answerFile(const http::RequestHead& head, const http::Route& route,
                                                 std::shared_ptr<const Model> model) {
  const bool is_private = host_.served.tokens != nullptr;
  const Obtained<http::Tileset> tileset = co_await obtain<http::Tileset>(host_.http->tileset(model));
  if (!tileset.content) co_return co_await refuseFile(head, tileset.status, route.model);
  if (!tileset.content->has(route.file)) co_return co_await refuse(head, 404, "the model has no such file");
  HttpContent wanted = host_.http->file(std::move(model), tileset.content, route.file);
  co_return co_await answerContent(head, route, std::move(wanted), is_private);
}

/// @param is_private  false if shared caches may keep the response.
asio::awaitable<bool> HttpConnection::answerContent(const http::RequestHead& head, const http::Route& route,
                                                    HttpContent wanted, bool is_private) {
  const bool is_binary = http::isBinary(route.resource);
  const bool is_constant = is_binary || route.resource == http::Resource::kTilesetPage;
  const bool is_packed = !is_binary && http::acceptsGzip(head.accept_encoding);
  const std::string plain_tag = "\"" + wanted.tag + "\"", packed_tag = "\"" + wanted.tag + "-gzip\"";
  http::ResponseHead response{.content_type = http::contentTypeOf(route.file)};
  response.etag = is_packed ? packed_tag : plain_tag;
  response.caching = is_constant ? http::Caching::kForever : http::Caching::kRevalidate;
  response.is_private = is_private;
  response.has_variants = !is_binary;
  response.is_gzip = is_packed;
  if (http::matchesAny(head.if_none_match, plain_tag) || http::matchesAny(head.if_none_match, packed_tag)) {
    response.status = 304;
    response.content_type = {};
    response.is_gzip = false;
    co_await send(response, {});
    co_return !closes_;
  }
  const Obtained<http::FileContent> file = co_await obtain<http::FileContent>(std::move(wanted));
  if (!file.content) co_return co_await refuseFile(head, file.status, route.model);
  co_return co_await sendContent(head, response, is_packed ? file.content->packed() : file.content->plain());
}

/// Sends a content or the range of it that the request asks for.
asio::awaitable<bool> HttpConnection::sendContent(const http::RequestHead& head, http::ResponseHead response,
                                                  std::span<const std::byte> body) {
  const bool takes_range = head.if_range.empty() || head.if_range == response.etag;
  const http::ContentRange range = http::parseRange(takes_range ? head.range : "", body.size());
  response.range = range;
  response.total_bytes = body.size();
  response.content_bytes = range.bytes;
  if (range.kind == http::RangeKind::kPart) response.status = 206;
  if (range.kind == http::RangeKind::kNotSatisfiable) response.status = 416;
  body = body.subspan(range.first, range.bytes);
  if (head.method == http::Method::kHead) body = {};
  co_await send(response, body);
  co_return !closes_;
}

/// Refuses a file that cannot be made. Counts errors of the store in the metrics.
asio::awaitable<bool> HttpConnection::refuseFile(const http::RequestHead& head, int status,
                                                 const std::string& model) {
  if (status == kDamagedStatus) {
    host_.counters->model(model).damaged.add();
    return refuse(head, status, "the file cannot be made, because its store is damaged");
  }
  if (status == kUnreadableStatus) {
    host_.counters->model(model).unreadable.add();
    return refuse(head, kBusyStatus, "the store cannot be read now; ask again later");
  }
  return refuse(head, status, "the server is busy; ask again later");
}

/// Refuses a token. If the token is wrong, waits before the answer as on the native port. Before the wait,
/// the connection releases its slot and its memory for other connections.
asio::awaitable<bool> HttpConnection::refuseToken(const http::RequestHead& head, bool is_blocked) {
  host_.counters->refused[static_cast<size_t>(RefusalReason::kToken)].add();
  if (is_blocked)
    co_return co_await refuse(head, 429, "this address sent too many wrong tokens; try again later", true);
  host_.log->write(LogKind::kUnauthorized, "a token is unknown or has expired", {{"client", client_}});
  const std::optional<WrongTokens::Wait> wait = host_.wrong_tokens->add(addressOfClient(), Clock::now());
  if (wait) {
    { const Slot left = std::move(slot_); }
    { const MemoryAccount left = std::move(memory_); }
    asio::error_code ignored;
    asio::steady_timer answer(stream_.executor(), wait->until());
    co_await answer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  }
  co_return co_await refuse(head, 401, "the token is unknown or has expired", true);
}

/// Sends an error. @param why  text for the client. @return false if the connection must end.
asio::awaitable<bool> HttpConnection::refuse(const http::RequestHead& head, int status, std::string why,
                                             bool closes) {
  closes_ = closes_ || closes;
  if (closes) {
    end(EndReason::kMistake);
    why_ = why;
  }
  why += '\n';
  http::ResponseHead response{.status = status, .content_type = kPlainText, .content_bytes = why.size()};
  response.extra = extraFieldsOf(status);
  const auto body = std::as_bytes(std::span(why));
  co_await send(response, head.method == http::Method::kHead ? body.first(0) : body);
  co_return !closes_;
}

/// Returns a cached content, or waits until a thread has made the content.
template <typename Kind>
asio::awaitable<HttpConnection::Obtained<Kind>> HttpConnection::obtain(HttpContent wanted) {
  http::ContentMakers& makers = host_.http->makers();
  if (auto cached = makers.find(wanted.key))
    co_return Obtained<Kind>{std::static_pointer_cast<const Kind>(cached)};
  const auto wait = std::make_shared<Wait>(stream_.executor());
  const bool is_queued =
      makers.make(wanted.key, std::move(wanted.make),
                  [wait, executor = stream_.executor()](http::MakeResult result,
                                                        std::shared_ptr<const http::Content> content) {
                    asio::post(executor, [wait, result, content = std::move(content)] {
                      wait->result = result;
                      wait->content = content;
                      wait->is_over = true;
                      wait->timer.cancel();
                    });
                  });
  if (!is_queued) co_return Obtained<Kind>{nullptr, kBusyStatus};
  asio::error_code ignored;
  wait->timer.expires_after(limits_.read);
  if (!wait->is_over) co_await wait->timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  if (!wait->is_over) co_return Obtained<Kind>{nullptr, kUnreadableStatus};
  co_return Obtained<Kind>{std::static_pointer_cast<const Kind>(wait->content), statusOf(wait->result)};
}

}  // namespace lode::serve
