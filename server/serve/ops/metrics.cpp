#include "server/serve/ops/metrics.h"

#include <functional>
#include <span>
#include <sstream>
#include <utility>

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

namespace lode::serve {

namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Threads = std::span<const std::unique_ptr<ThreadCounters>>;

constexpr std::array<std::string_view, kRequestClasses> kClassNames{"visible", "margin", "prefetch"};

ClientMetric labelled(const char* label, std::string_view value) {
  ClientMetric metric;
  metric.label.push_back({label, std::string(value)});
  return metric;
}

MetricFamily number(const char* name, const char* help, MetricType type, uint64_t value) {
  MetricFamily family{name, help, type, {ClientMetric()}};
  (type == MetricType::Gauge ? family.metric[0].gauge.value : family.metric[0].counter.value) =
      static_cast<double>(value);
  return family;
}

/// Adds up one counter over all threads; `counter` selects the counter.
uint64_t sum(Threads threads, const auto& counter) {
  uint64_t total = 0;
  for (const auto& thread : threads) total += counter(*thread).read();
  return total;
}

/// Creates a family with one counter for each of the `count` values of a label.
MetricFamily labelledCounters(const char* name, const char* help, const char* label, size_t count,
                              Threads threads, const auto& name_of, const auto& counter) {
  MetricFamily family{name, help, MetricType::Counter, {}};
  for (size_t i = 0; i < count; ++i) {
    ClientMetric metric = labelled(label, name_of(i));
    metric.counter.value = static_cast<double>(
        sum(threads, [&](const ThreadCounters& t) -> const Counter& { return counter(t)[i]; }));
    family.metric.push_back(std::move(metric));
  }
  return family;
}

MetricFamily latencies(const char* name, const char* help, Threads threads, const auto& counter) {
  MetricFamily family{name, help, MetricType::Histogram, {}};
  for (size_t c = 0; c < kRequestClasses; ++c) {
    ClientMetric metric = labelled("class", kClassNames[c]);
    auto& histogram = metric.histogram;
    for (size_t bucket = 0; bucket < LatencyCounter::kBuckets; ++bucket) {
      for (const auto& thread : threads) histogram.sample_count += counter(*thread)[c].bucket(bucket);
      if (bucket < kLatencyBoundsSeconds.size())
        histogram.bucket.push_back({histogram.sample_count, kLatencyBoundsSeconds[bucket]});
    }
    for (const auto& thread : threads)
      histogram.sample_sum += static_cast<double>(counter(*thread)[c].sumNs()) * 1e-9;
    family.metric.push_back(std::move(metric));
  }
  return family;
}

struct ModelFigure {
  const char *name, *help;
  Counter ModelCounters::*counter;
};
constexpr std::array kModelFigures{
    ModelFigure{"lodestream_model_opened_total", "Number of times that clients opened the model",
                &ModelCounters::opened},
    ModelFigure{"lodestream_model_blobs_sent_total", "Blobs sent completely", &ModelCounters::blobs},
    ModelFigure{"lodestream_model_sent_bytes_total", "Bytes of blobs sent", &ModelCounters::bytes},
    ModelFigure{"lodestream_model_cold_reads_total", "Reads that waited for the disk",
                &ModelCounters::cold_reads},
    ModelFigure{"lodestream_model_damaged_blobs_total", "Requests that failed because the store is damaged",
                &ModelCounters::damaged},
    ModelFigure{"lodestream_model_unreadable_blobs_total",
                "Requests that failed because the store could not be read", &ModelCounters::unreadable},
};

MetricFamily ofModels(const ModelFigure& figure, Threads threads) {
  std::map<std::string, uint64_t> by_name;
  for (const auto& thread : threads)
    thread->forEachModel([&](const std::string& name, const ModelCounters& counters) {
      by_name[name] += (counters.*figure.counter).read();
    });
  MetricFamily family{figure.name, figure.help, MetricType::Counter, {}};
  for (const auto& [name, value] : by_name) {
    family.metric.push_back(labelled("model", name));
    family.metric.back().counter.value = static_cast<double>(value);
  }
  return family;
}

void addGauges(std::vector<MetricFamily>& families, const ServerGauges& gauges) {
  const auto add = [&](const char* name, const char* help, MetricType type, uint64_t value) {
    families.push_back(number(name, help, type, value));
  };
  add("lodestream_connections", "Open connections", MetricType::Gauge, gauges.connections);
  add("lodestream_models", "Models served", MetricType::Gauge, gauges.models);
  add("lodestream_models_skipped", "Stores that could not be opened at the start or at the last reload",
      MetricType::Gauge, gauges.models_skipped);
  add("lodestream_memory_bytes", "Bytes of the memory budget that connections hold", MetricType::Gauge,
      gauges.memory_bytes);
  add("lodestream_memory_budget_bytes", "Memory budget of all connections together in bytes",
      MetricType::Gauge, gauges.memory_budget_bytes);
  add("lodestream_allocated_bytes", "Bytes that the process has allocated and not freed", MetricType::Gauge,
      gauges.allocated_bytes);
  if (gauges.certificate_expires_s > 0)
    add("lodestream_certificate_expires_seconds", "Unix time at which the TLS certificate expires",
        MetricType::Gauge, gauges.certificate_expires_s);
  if (gauges.http_cache_limit_bytes > 0) {
    add("lodestream_http_cache_bytes", "Memory of tiles and pages for HTTP, cached or being sent",
        MetricType::Gauge, gauges.http_cache_bytes);
    add("lodestream_http_cache_limit_bytes", "Limit of lodestream_http_cache_bytes (--http-memory)",
        MetricType::Gauge, gauges.http_cache_limit_bytes);
    add("lodestream_http_contents_made_total", "Tiles and pages made for HTTP because the cache lacked them",
        MetricType::Counter, gauges.http_contents_made);
  }
  add("lodestream_stopping", "1 while the server is stopping, else 0", MetricType::Gauge, gauges.stopping);
  add("lodestream_log_lines_dropped_total", "Log lines dropped because nobody read them", MetricType::Counter,
      gauges.log_lines_dropped);
  add("lodestream_log_lines_left_out_total", "Log lines left out by the rate limit of their kind",
      MetricType::Counter, gauges.log_lines_left_out);
}

void addHttp(std::vector<MetricFamily>& families, Threads threads) {
  families.push_back(labelledCounters(
      "lodestream_http_responses_total", "HTTP responses, by status", "status", kHttpStatuses.size(), threads,
      [](size_t i) { return std::to_string(kHttpStatuses[i]); },
      [](const ThreadCounters& t) -> const auto& { return t.http_responses; }));
  families.push_back(
      number("lodestream_http_sent_bytes_total", "Bytes of HTTP responses", MetricType::Counter,
             sum(threads, [](const ThreadCounters& t) -> const Counter& { return t.http_sent_bytes; })));
}

}  // namespace

std::string_view refusalName(RefusalReason reason) noexcept {
  constexpr std::array<std::string_view, kRefusalReasons> kNames{
      "connections", "address", "memory", "descriptors", "token", "proxy_header", "tls"};
  return kNames[static_cast<size_t>(reason)];
}

std::string_view endName(EndReason reason) noexcept {
  constexpr std::array<std::string_view, kEndReasons> kNames{
      "client",    "broken", "proxy_header", "tls",    "mistake",
      "handshake", "idle",   "stalled",      "memory", "stopping"};
  return kNames[static_cast<size_t>(reason)];
}

ModelCounters& ThreadCounters::model(const std::string& name) {
  const std::lock_guard lock(mutex_);
  return models_[name];
}

Metrics::Metrics(size_t threads) {
  for (size_t i = 0; i < threads; ++i) threads_.push_back(std::make_unique<ThreadCounters>());
}

std::string Metrics::text(const ServerGauges& gauges) const {
  std::vector<MetricFamily> families;
  addGauges(families, gauges);
  families.push_back(
      number("lodestream_connections_accepted_total",
             "Connections accepted, before TLS, the balancer's header and the token are checked",
             MetricType::Counter,
             sum(threads_, [](const ThreadCounters& t) -> const Counter& { return t.accepted; })));
  families.push_back(labelledCounters(
      "lodestream_connections_refused_total", "Connections refused, before or after accept, by reason",
      "reason", kRefusalReasons, threads_,
      [](size_t i) { return refusalName(static_cast<RefusalReason>(i)); },
      [](const ThreadCounters& t) -> const auto& { return t.refused; }));
  families.push_back(labelledCounters(
      "lodestream_connections_ended_total", "Accepted connections that have ended, by reason", "reason",
      kEndReasons, threads_, [](size_t i) { return endName(static_cast<EndReason>(i)); },
      [](const ThreadCounters& t) -> const auto& { return t.ended; }));
  families.push_back(labelledCounters(
      "lodestream_requests_total", "Requests received, by class", "class", kRequestClasses, threads_,
      [](size_t i) { return kClassNames[i]; },
      [](const ThreadCounters& t) -> const auto& { return t.requests; }));
  families.push_back(latencies(
      "lodestream_request_queue_seconds",
      "Time from a request to its first chunk, without request_held_seconds", threads_,
      [](const ThreadCounters& t) -> const auto& { return t.queue; }));
  families.push_back(latencies(
      "lodestream_request_held_seconds",
      "Time from a request to its first chunk in which the client's window was shut or its link was full",
      threads_, [](const ThreadCounters& t) -> const auto& { return t.held; }));
  families.push_back(latencies(
      "lodestream_request_send_seconds", "Time from a request to its last chunk", threads_,
      [](const ThreadCounters& t) -> const auto& { return t.send; }));
  if (gauges.http_cache_limit_bytes > 0) addHttp(families, threads_);
  for (const ModelFigure& figure : kModelFigures) families.push_back(ofModels(figure, threads_));
  std::erase_if(families, [](const MetricFamily& family) { return family.metric.empty(); });
  std::ostringstream out;
  prometheus::TextSerializer().Serialize(out, families);
  return out.str();
}

}  // namespace lode::serve
