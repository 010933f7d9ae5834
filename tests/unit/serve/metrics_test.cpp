#include "server/serve/ops/metrics.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/serve/small_store.h"

namespace lode::serve {
namespace {

using namespace std::chrono_literals;

void expectLine(const std::string& text, const std::string& line) {
  EXPECT_NE(("\n" + text).find("\n" + line + "\n"), std::string::npos) << line << "\nis not in\n" << text;
}

/// Metrics of two threads with every counter above 0.
Metrics busyMetrics() {
  Metrics metrics(2);
  for (size_t thread = 0; thread < 2; ++thread) {
    ThreadCounters& counters = metrics.ofThread(thread);
    counters.accepted.add(10);
    counters.refused[static_cast<size_t>(RefusalReason::kToken)].add(3);
    counters.ended[static_cast<size_t>(EndReason::kIdle)].add();
    counters.requests[0].add(7);
    counters.queue[0].add(1500us);
    counters.held[1].add(3s);
    counters.send[2].add(1min);
    ModelCounters& bunny = counters.model("bunny");
    bunny.opened.add();
    bunny.bytes.add(1'000'000'007);
    bunny.cold_reads.add(2);
    bunny.damaged.add(1);
  }
  metrics.ofThread(1).model("a \"quoted\\ name\"").blobs.add(4);
  return metrics;
}

TEST(Metrics, areSummedOverThreads) {
  const std::string text = busyMetrics().text({});
  expectLine(text, "lodestream_connections_accepted_total 20");
  expectLine(text, "lodestream_connections_refused_total{reason=\"token\"} 6");
  expectLine(text, "lodestream_connections_ended_total{reason=\"idle\"} 2");
  expectLine(text, "lodestream_requests_total{class=\"visible\"} 14");
  expectLine(text, "lodestream_model_sent_bytes_total{model=\"bunny\"} 2000000014");
  expectLine(text, "lodestream_model_damaged_blobs_total{model=\"bunny\"} 2");
}

TEST(Metrics, putDurationsIntoCumulativeBuckets) {
  const std::string text = busyMetrics().text({});
  expectLine(text, "lodestream_request_queue_seconds_bucket{class=\"visible\",le=\"0.001\"} 0");
  expectLine(text, "lodestream_request_queue_seconds_bucket{class=\"visible\",le=\"0.002\"} 2");
  expectLine(text, "lodestream_request_queue_seconds_bucket{class=\"visible\",le=\"10\"} 2");
  expectLine(text, "lodestream_request_queue_seconds_count{class=\"visible\"} 2");
  expectLine(text, "lodestream_request_queue_seconds_sum{class=\"visible\"} 0.003");
  expectLine(text, "lodestream_request_held_seconds_sum{class=\"margin\"} 6");
  expectLine(text, "lodestream_request_send_seconds_bucket{class=\"prefetch\",le=\"10\"} 0");
  expectLine(text, "lodestream_request_send_seconds_bucket{class=\"prefetch\",le=\"+Inf\"} 2");
}

TEST(Metrics, reportCurrentValues) {
  ServerGauges gauges;
  gauges.connections = 12;
  gauges.memory_bytes = 345;
  gauges.memory_budget_bytes = 6789;
  gauges.allocated_bytes = 9876;
  gauges.stopping = true;
  const std::string text = Metrics(1).text(gauges);
  expectLine(text, "lodestream_connections 12");
  expectLine(text, "lodestream_memory_bytes 345");
  expectLine(text, "lodestream_memory_budget_bytes 6789");
  expectLine(text, "lodestream_allocated_bytes 9876");
  expectLine(text, "lodestream_stopping 1");
}

TEST(Metrics, nameEveryReasonOnce) {
  std::set<std::string_view> refusals, ends;
  for (size_t i = 0; i < kRefusalReasons; ++i) refusals.insert(refusalName(static_cast<RefusalReason>(i)));
  for (size_t i = 0; i < kEndReasons; ++i) ends.insert(endName(static_cast<EndReason>(i)));
  EXPECT_EQ(refusals.size(), kRefusalReasons);
  EXPECT_EQ(ends.size(), kEndReasons);
  EXPECT_FALSE(refusals.contains("") || ends.contains(""));
}

TEST(Metrics, areReadWhileTheyAreCounted) {
  Metrics metrics(1);
  std::jthread counting([&metrics] {
    for (int i = 0; i < 10'000; ++i) {
      metrics.ofThread(0).accepted.add();
      metrics.ofThread(0).queue[0].add(1ms);
      metrics.ofThread(0).model("m" + std::to_string(i % 10)).bytes.add(5);
    }
  });
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(metrics.text({}).empty());
  counting.join();
  expectLine(metrics.text({}), "lodestream_connections_accepted_total 10000");
}

TEST(Metrics, passPromtool) {
  if (std::system("promtool --version >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "promtool is not installed: it comes with Debian's package prometheus";
  const test::WorkFolder folder;
  const auto path = folder.path() / "metrics.txt";
  std::ofstream(path) << busyMetrics().text({});
  EXPECT_EQ(std::system(("promtool check metrics < " + path.string()).c_str()), 0);
}

}  // namespace
}  // namespace lode::serve
