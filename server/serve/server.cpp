#include "server/serve/server.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <utility>

#include <asio/post.hpp>
#include <malloc.h>

#include "common/error.h"
#include "common/io/own_folder.h"
#include "server/http/response_head.h"
#include "server/http/route.h"
#include "server/serve/access.h"
#include "server/serve/memory/memory_reserve.h"
#include "server/serve/net/acceptor.h"
#include "server/serve/net/admission.h"
#include "server/serve/net/http_files.h"
#include "server/serve/net/listener.h"
#include "server/serve/net/wrong_tokens.h"
#include "server/serve/ops/health_endpoint.h"
#include "server/serve/ops/metrics.h"
#include "server/serve/worker.h"

namespace lode::serve {

namespace {

/// Descriptors reserved for everything except connections, stores and refusals.
constexpr uint64_t kOtherDescriptors = 64;
constexpr auto kMaintainEvery = std::chrono::milliseconds(100);
constexpr const char* kOpenKey = "other users can read or change the private key; chmod it to 600";
/// Smallest number of freed bytes for which maintain() calls malloc_trim().
constexpr uint64_t kTrimBytes = 1u << 20;

/// Removes the folders of all configured paths from a message, because readers of the log must not see the
/// machine's folders.
std::string withoutFolders(std::string message, const ServeOptions& options) {
  std::vector<std::filesystem::path> named = options.stores;
  named.insert(named.end(), {options.token_file, options.tls_certificate, options.tls_key});
  for (const auto& path : named)
    for (const std::string& folder : {(path / "").string(), (path.parent_path() / "").string()})
      for (size_t at = message.find(folder); !folder.empty() && at != std::string::npos;
           at = message.find(folder))
        message.erase(at, folder.size());
  return message;
}

/// Returns the bytes that this process has allocated from malloc and not freed.
uint64_t allocatedBytes() noexcept {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

unsigned threadsOf(const ServeOptions& options) {
  return options.threads == 0 ? std::max(1u, std::thread::hardware_concurrency()) : options.threads;
}

/// Returns an HTTP response that refuses a connection.
proto::Bytes httpRefusal(const std::string& why) {
  const std::string body = why + "\n";
  const std::string text = http::formatHead({.status = 503,
                                             .content_type = "text/plain; charset=utf-8",
                                             .content_bytes = body.size(),
                                             .closes = true,
                                             .extra = http::kRetryField},
                                            std::time(nullptr)) +
                           body;
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

struct Server::State {
  explicit State(ServeOptions given);
  ~State();

  BlobReaderOptions readerOptions();
  std::shared_ptr<const TokenFile> openTokens();
  std::shared_ptr<asio::ssl::context> openCertificate();
  uint32_t possibleConnections();
  ConnectionLimits limits() const;
  ServerGauges gauges() const;
  asio::ip::tcp::acceptor openListeningSocket();
  void listen();
  void listenForHttp(bool is_native_local);
  std::unique_ptr<Acceptor> makeAcceptor(asio::ip::tcp::acceptor listener, ClientProtocol protocol);
  void startWorkers();
  void run();
  void reload();
  void inspect(const Published& now_served);
  void warnOfUnknownModels(const ServedSet& served);
  void halt();
  void maintain();
  void stopNow();
  void closeAcceptor();

  MemoryReserve reserve;
  size_t blocks_taken = 0;  ///< value of MemoryReserve::taken() at the last maintain()
  ServeOptions options;
  /// Initialized here, because the limit must be raised before stores are opened.
  const uint64_t open_files = raiseOpenFileLimit();
  /// Shared with reads that may outlive the server: see DiskReaders::join().
  const std::shared_ptr<Log> log;
  std::vector<SkippedStore> skipped;  ///< stores that the constructor skipped
  std::mutex reload_mutex;            ///< locked during a whole reload, which may wait for a disk
  std::mutex published_mutex;         ///< guards published and workers; locked only briefly
  Published published;                ///< written by the constructor and reload() only
  MemoryBudget budget;
  ByteRate rate;
  WrongTokens wrong_tokens;
  Admission admission;
  Metrics metrics;
  std::atomic<bool> stopping{false};
  std::atomic<size_t> models{0}, models_skipped{0};
  std::atomic<uint64_t> certificate_expires_s{0};  ///< Unix time of the expiry; 0 without TLS
  std::string address, http_address, page_link;
  uint16_t port = 0;
  /// Context for accepting connections and for the health port; runs on run()'s thread.
  asio::io_context context{1};
  std::unique_ptr<Acceptor> acceptor, http_acceptor;  ///< http_acceptor is null without HTTP
  std::unique_ptr<HealthEndpoint> health;
  asio::steady_timer drain_timer{context}, maintain_timer{context};
  uint64_t peak_bytes = 0;       ///< peak use of the budget since the last trim
  uint64_t last_used_bytes = 0;  ///< use of the budget at the last call of maintain()
  std::vector<std::unique_ptr<Worker>> workers;
  std::unique_ptr<HttpFiles> http_files;  ///< null without HTTP
  DiskReaders readers;
};

Server::State::State(ServeOptions given)
    : options(std::move(given)),
      log(std::make_shared<Log>(options.log)),
      published{
          {openCatalog(options.stores, readerOptions(), options.strict ? nullptr : &skipped), openTokens()},
          openCertificate()},
      budget(options.memory_budget_bytes == 0 ? defaultMemoryBudget() : options.memory_budget_bytes),
      rate(options.bytes_per_second),
      wrong_tokens(options.wrong_token_delay),
      admission(possibleConnections(), options.max_connections_per_address),
      metrics(threadsOf(options) + 1),
      models_skipped(skipped.size()),
      readers({.deadline = options.read_deadline}) {
  inspect(published);
  listen();
}

Server::State::~State() {
  halt();
  for (auto& worker : workers) worker->join();
  // Join the readers before the workers' contexts are destroyed, because reads end on these contexts.
  readers.join();
  if (http_files) http_files->makers().join();
}

BlobReaderOptions Server::State::readerOptions() {
  return {.check_file_every = options.check_stores_every,
          .report = [log = log](StoreFault fault, std::string_view line) {
            const bool is_damage = fault == StoreFault::kDamaged;
            log->write(is_damage ? LogKind::kDamagedStore : LogKind::kUnreadableStore, line);
          }};
}

std::shared_ptr<const TokenFile> Server::State::openTokens() {
  if (options.token_file.empty()) return nullptr;
  if (isOpenToOthers(options.token_file))
    log->write(LogKind::kServer, "other users can read or change the token file; chmod it to 600");
  return std::make_shared<const TokenFile>(TokenFile::read(options.token_file));
}

std::shared_ptr<asio::ssl::context> Server::State::openCertificate() {
  if (options.tls_certificate.empty() != options.tls_key.empty())
    throw Error(ErrorCode::kUsage, "--tls-cert needs --tls-key and the reverse; give both");
  if (options.tls_certificate.empty()) return nullptr;
  if (isOpenToOthers(options.tls_key)) {
    if (!options.insecure)
      throw Error(ErrorCode::kUsage, options.tls_key.string() + ": " + kOpenKey + ", or give --insecure");
    log->write(LogKind::kServer, kOpenKey);
  }
  return openTls(options.tls_certificate, options.tls_key);
}

/// Returns --max-connections, or fewer connections if the limit of open files does not allow as many.
uint32_t Server::State::possibleConnections() {
  const uint64_t others = kOtherDescriptors + (options.http.empty() ? 1 : 2) * Refusals::kMost +
                          WrongTokens::kMostWaiting + 2 * published.served.catalog->models().size();
  const uint64_t room = open_files > 2 * others ? open_files - others : open_files / 2;
  if (room >= options.max_connections) return options.max_connections;
  log->write(LogKind::kServer,
             "the limit of open files allows fewer connections than --max-connections; raise it",
             {{"possible", room}, {"wanted", uint64_t{options.max_connections}}, {"open_files", open_files}});
  return static_cast<uint32_t>(room);
}

ConnectionLimits Server::State::limits() const {
  return {.session = {.max_open_requests = options.max_open_requests,
                      .handshake = options.handshake_deadline,
                      .idle = options.idle_deadline,
                      .max_open_models = options.max_open_models},
          .write = options.write_deadline,
          .bytes_per_second = options.bytes_per_second_per_connection,
          .queued_answer_bytes = options.max_queued_answer_bytes,
          .proxy_protocol = options.proxy_protocol,
          .read = options.read_deadline};
}

ServerGauges Server::State::gauges() const {
  http::ContentMakers* const made = http_files ? &http_files->makers() : nullptr;
  return {.connections = admission.count(),
          .models = models,
          .models_skipped = models_skipped,
          .certificate_expires_s = certificate_expires_s,
          .memory_bytes = budget.used(),
          .memory_budget_bytes = budget.limit(),
          .allocated_bytes = allocatedBytes(),
          .log_lines_dropped = log->linesDropped(),
          .log_lines_left_out = log->linesLeftOut(),
          .http_cache_bytes = made != nullptr ? made->cache().usedBytes() : 0,
          .http_cache_limit_bytes = made != nullptr ? made->cache().limitBytes() : 0,
          .http_contents_made = made != nullptr ? made->made() : 0,
          .stopping = stopping};
}

asio::ip::tcp::acceptor Server::State::openListeningSocket() {
  if (options.listening_socket) {
    asio::ip::tcp::acceptor given = adoptListener(context, *options.listening_socket);
    checkAccessBeyondLoopback(options, given.local_endpoint());
    return given;
  }
  const asio::ip::tcp::endpoint endpoint = resolveListen(context, options.listen);
  checkAccessBeyondLoopback(options, endpoint);
  return openListener(context, endpoint, "--listen");
}

std::unique_ptr<Acceptor> Server::State::makeAcceptor(asio::ip::tcp::acceptor listener,
                                                      ClientProtocol protocol) {
  const AcceptorOptions acceptor_options{
      .count_addresses = !options.proxy_protocol,
      .connection_bytes = published.tls ? kTlsConnectionBytes : kPlainConnectionBytes,
      .refusal = protocol == ClientProtocol::kHttp ? httpRefusal : nativeRefusal};
  auto made = std::make_unique<Acceptor>(
      std::move(listener), acceptor_options, admission, budget, metrics.ofThread(0), *log,
      [this, protocol](asio::ip::tcp::socket socket, Slot slot, MemoryAccount memory, std::string client) {
        Worker& worker = **std::ranges::min_element(workers, {}, [](const auto& w) { return w->load(); });
        worker.give(std::move(socket), std::move(slot), std::move(memory), std::move(client), protocol);
      });
  made->setTls(published.tls);
  return made;
}

void Server::State::listen() {
  asio::ip::tcp::acceptor listener = openListeningSocket();
  port = listener.local_endpoint().port();
  address = toString(listener.local_endpoint());
  const bool is_native_local = listener.local_endpoint().address().is_loopback();
  acceptor = makeAcceptor(std::move(listener), ClientProtocol::kNative);
  if (!options.http.empty()) listenForHttp(is_native_local);
  if (options.metrics.empty()) return;
  checkMetricsBeyondLoopback(options, resolveListen(context, options.metrics));
  health = std::make_unique<HealthEndpoint>(
      context, options.metrics,
      HealthAnswers{[this] { return metrics.text(gauges()); }, [this] { return !stopping; }});
}

void Server::State::listenForHttp(bool is_native_local) {
  const asio::ip::tcp::endpoint endpoint = resolveListen(context, options.http);
  checkAccessBeyondLoopback(options, endpoint);
  asio::ip::tcp::acceptor listener = openListener(context, endpoint, "--http");
  const asio::ip::tcp::endpoint opened = listener.local_endpoint();
  http_address = toString(opened);
  http_acceptor = makeAcceptor(std::move(listener), ClientProtocol::kHttp);
  HttpSite site{options.page, http::NativePort{port, published.tls != nullptr}, is_native_local};
  if (options.proxy_protocol) site.native.reset();  // clients reach the native port through a balancer only
  http_files = std::make_unique<HttpFiles>(
      http::ContentMakersOptions{.threads = threadsOf(options), .memory_bytes = options.http_memory_bytes},
      log, site);
  const std::string host =
      opened.address().is_unspecified() ? "localhost:" + std::to_string(opened.port()) : http_address;
  page_link = (published.tls ? "https://" : "http://") + host + "/";
  const auto shown = published.served.catalog->models();
  if (shown.size() == 1) page_link += "#model=" + http::percentEncode(shown.front()->summary.name);
  log->write(LogKind::kServer, "a browser shows the models at " + page_link);
}

void Server::State::startWorkers() {
  const unsigned threads = threadsOf(options);
  const auto shortest =
      std::min({options.handshake_deadline, options.idle_deadline, options.write_deadline}) / 4;
  const auto sweep_every =
      std::clamp<std::chrono::milliseconds>(shortest, std::chrono::milliseconds(5), std::chrono::seconds(1));
  const WorkerShared shared{*log,         readers,  budget,           rate,
                            wrong_tokens, limits(), http_files.get(), options.public_ok};
  const std::lock_guard lock(published_mutex);
  try {
    for (unsigned i = 0; i < threads; ++i)
      workers.push_back(std::make_unique<Worker>(published, shared, metrics.ofThread(i + 1)));
    for (auto& worker : workers) worker->start(sweep_every);
  } catch (const std::system_error& error) {
    throw Error(ErrorCode::kIo, "cannot start " + std::to_string(threads) + " threads: " + error.what() +
                                    "; give a smaller --threads");
  }
}

void Server::State::run() {
  startWorkers();
  const auto guard = asio::make_work_guard(context);
  while (true) try {
      acceptor->open();
      if (http_acceptor) http_acceptor->open();
      maintain();
      context.run();
      break;
    } catch (const std::exception& error) {  // usually memory ran out; go on accepting connections
      log->write(LogKind::kSystem, reasonOf(error));
    }
  halt();
  for (auto& worker : workers) worker->join();
}

/// Runs every kMaintainEvery. Ends late reads and refills the reserve. Trims the heap once the used part of
/// the budget has fallen below half of its peak and no longer falls. Without the trim, malloc would keep
/// nearly all the memory that a flood of requests or answers needed.
void Server::State::maintain() {
  readers.tick();
  MemoryReserve::refill();
  if (const size_t taken = MemoryReserve::taken(); std::exchange(blocks_taken, taken) != taken)
    log->write(LogKind::kSystem, "the system has no memory left; the server used its reserve");
  const uint64_t used = budget.used();
  const bool falls = used < std::exchange(last_used_bytes, used);
  peak_bytes = std::max(peak_bytes, used);
  if (!falls && used < peak_bytes / 2 && peak_bytes - used >= kTrimBytes) {
    peak_bytes = used;
    readers.post([] { malloc_trim(0); });
  }
  maintain_timer.expires_after(kMaintainEvery);
  maintain_timer.async_wait([this](const asio::error_code& cancelled) {
    if (!cancelled) maintain();
  });
}

void Server::State::reload() {
  const std::lock_guard lock(reload_mutex);
  Published next = published;
  bool complete = true;
  const auto reloadPart = [&](const char* what, const auto& action) {
    try {
      action();
    } catch (const std::exception& error) {
      log->write(LogKind::kServer, std::string(what) + " could not be reloaded; the previous version stays",
                 {{"why", withoutFolders(error.what(), options)}});
      complete = false;
    }
  };
  std::vector<SkippedStore> unopened;
  reloadPart("stores", [&] {
    next.served.catalog = reopenCatalog(*next.served.catalog, options.stores, readerOptions(), unopened);
    models_skipped = unopened.size();
  });
  reloadPart("tokens", [&] { next.served.tokens = openTokens(); });
  reloadPart("the certificate", [&] { next.tls = openCertificate(); });
  reloadPart("the served set", [&] { inspect(next); });
  {
    const std::lock_guard published_lock(published_mutex);
    published = next;
    for (auto& worker : workers) worker->publish(next);
  }
  if (http_files) http_files->retain(*next.served.catalog);
  asio::post(context, [this, now = next.tls] {
    acceptor->setTls(now);
    if (http_acceptor) http_acceptor->setTls(now);
  });
  complete = complete && unopened.empty();
  log->write(LogKind::kServer, complete ? "reloaded" : "reloaded partly", {{"models", uint64_t{models}}});
}

/// Updates the gauges for a new served set and certificate. Logs likely mistakes: tokens for unknown models,
/// expired tokens, an expired certificate.
void Server::State::inspect(const Published& now_served) {
  const auto& [served, tls] = now_served;
  models = served.catalog->models().size();
  // Export a zero for each model, because Prometheus sees an increase only in a counter that it has read
  // before.
  for (const auto& model : served.catalog->models()) metrics.ofThread(0).model(model->summary.name);
  warnOfUnknownModels(served);
  const auto now = std::chrono::system_clock::now();
  if (served.tokens && served.tokens->allHaveExpired(now))
    log->write(
        LogKind::kServer,
        "all tokens of the token file have expired, so every client is refused; add new ones and reload");
  const auto expires = tls ? expiryOf(*tls) : std::nullopt;
  certificate_expires_s =
      expires ? static_cast<uint64_t>(std::max<int64_t>(1, expires->time_since_epoch().count())) : 0;
  if (expires && *expires <= now)
    log->write(
        LogKind::kServer,
        "the certificate has expired, so clients refuse the server; install a new certificate and reload");
}

void Server::State::warnOfUnknownModels(const ServedSet& served) {
  if (!served.tokens) return;
  std::vector<std::string> unknown = served.tokens->modelsNamed();
  std::erase_if(unknown, [&](const std::string& name) { return served.catalog->find(name) != nullptr; });
  if (!unknown.empty())
    log->write(LogKind::kServer, "the token file names models that are not served",
               {{"first", unknown.front()}, {"count", uint64_t{unknown.size()}}});
}

void Server::State::halt() {
  context.stop();
  const std::lock_guard lock(published_mutex);
  for (auto& worker : workers) worker->halt();
}

void Server::State::stopNow() {
  if (stopping.exchange(true)) {
    drain_timer.cancel();  // the timer's handler then runs at once
    return;
  }
  log->write(LogKind::kServer, "stopping");
  drain_timer.expires_after(options.drain_delay);
  drain_timer.async_wait([this](const asio::error_code&) { closeAcceptor(); });
}

void Server::State::closeAcceptor() {
  acceptor->close();
  if (http_acceptor) http_acceptor->close();
  for (auto& worker : workers) worker->drain("the server is stopping");
  drain_timer.expires_after(options.drain_deadline);
  drain_timer.async_wait([this](const asio::error_code&) { context.stop(); });
  admission.whenEmpty([this] { context.stop(); });
}

Server::Server(ServeOptions options) : state_(std::make_unique<State>(std::move(options))) {}
Server::~Server() = default;

uint16_t Server::port() const noexcept { return state_->port; }

std::string Server::address() const { return state_->address; }

std::optional<std::string> Server::metricsAddress() const {
  if (!state_->health) return {};
  return state_->health->address();
}

std::optional<std::string> Server::httpAddress() const {
  if (state_->options.http.empty()) return {};
  return state_->http_address;
}

std::optional<std::string> Server::pageLink() const {
  if (state_->options.http.empty()) return {};
  return state_->page_link;
}

std::vector<std::string> Server::models() const {
  const std::lock_guard lock(state_->published_mutex);
  std::vector<std::string> names;
  for (const auto& model : state_->published.served.catalog->models()) names.push_back(model->summary.name);
  return names;
}

const std::vector<SkippedStore>& Server::skipped() const noexcept { return state_->skipped; }

uint64_t Server::memoryHeld() const noexcept { return state_->budget.used(); }

void Server::run() { state_->run(); }

void Server::reload() { state_->reload(); }

void Server::stop() {
  asio::post(state_->context, [state = state_.get()] { state->stopNow(); });
}

}  // namespace lode::serve
