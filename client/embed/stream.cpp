#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <string>

#include "client/embed/internal.h"
#include "client/embed/lodestream.h"
#include "client/stream/blob_cache.h"
#include "client/stream/decode_pool.h"
#include "client/stream/served_model.h"
#include "client/stream/streamer.h"
#include "common/codec/texture_set.h"
#include "common/error.h"

struct lodestream_stream {
  lodestream_stream(lode::stream::ServedModel served, lode::stream::StreamOptions options)
      : streamer(std::move(served), std::move(options)) {}

  lode::stream::Streamer streamer;
  std::optional<lode::ModelSummary> model;
  std::shared_ptr<const lode::core::Cut> cut;  // cut of the last step
  uint64_t cut_serial = 0;
  std::optional<lode::core::View> view;  // view that was set last
  float threshold_px = 1;
};

namespace lode::embed {
namespace {

std::string& lastError() {
  thread_local std::string message;
  return message;
}

void copyTo(double (&values)[3], const glm::dvec3& vector) {
  for (int axis = 0; axis < 3; ++axis) values[axis] = vector[axis];
}

lodestream_stream& streamAt(lodestream_stream* stream) {
  return given(stream, "stream", "the one from lodestream_open()");
}

const ModelSummary& modelOf(const lodestream_stream& stream) {
  if (!stream.model)
    throw Error(ErrorCode::kUsage, "the model is not open yet: call lodestream_step() until is_open is set");
  return *stream.model;
}

/// Converts the options of the C API. @throws Error for an invalid option.
stream::StreamOptions toStreamOptions(const lodestream_options& options) {
  const auto textOf = [](const char* text) { return text != nullptr ? std::string(text) : std::string(); };
  stream::StreamOptions of_stream;
  of_stream.engine.session.token = textOf(options.token);
  of_stream.ca_file = textOf(options.ca_file);
  of_stream.cache_folder = textOf(options.cache_folder);
  if (!of_stream.cache_folder.empty()) stream::prepareCacheFolder(of_stream.cache_folder);
  if (options.memory_budget_bytes != 0) of_stream.engine.memory_budget_bytes = options.memory_budget_bytes;
  if (options.triangle_budget != 0) of_stream.engine.refine.triangle_budget = options.triangle_budget;
  if (options.connect_timeout_ms != 0)
    of_stream.connect_timeout = std::chrono::milliseconds(options.connect_timeout_ms);
  if (options.decode_threads > stream::kMaxDecodeThreads)
    throw Error(ErrorCode::kUsage, "decode_threads is " + std::to_string(options.decode_threads) +
                                       ", but at most " + std::to_string(stream::kMaxDecodeThreads) +
                                       " are allowed; 0 selects the default");
  of_stream.decode_threads = options.decode_threads;
  return of_stream;
}

lodestream_status toStatus(const stream::StreamStatus& status, const lodestream_stream& stream) {
  lodestream_status result{};
  result.is_open = stream.model.has_value();
  result.has_cut = status.cut != nullptr;
  const bool is_of_view = status.cut && status.cut->view == stream.view;
  result.is_converged = is_of_view && isWithin(*status.cut, stream.threshold_px);
  result.is_finest = is_of_view && status.cut->threshold_px == stream.threshold_px && isFinest(*status.cut);
  result.cut_serial = stream.cut_serial;
  result.is_settled = status.settled;
  result.is_limited = status.limited;
  result.is_reconnecting = !status.trouble.empty();
  result.has_failed = !status.failure.empty();
  result.has_ended = status.ended;
  result.received_bytes = status.counts.received_bytes;
  result.resident_bytes = status.counts.resident_bytes;
  return result;
}

}  // namespace

const char* wordsFor(Remedy remedy) noexcept {
  switch (remedy) {
    case Remedy::kNone:
      return "";
    case Remedy::kModel:
      return "name a model of this server";
    case Remedy::kToken:
      return "set the option token to a valid one";
    case Remedy::kCertificate:
      return "use the host name of the certificate, and set the option ca_file to its authority";
    case Remedy::kAuthorities:
      return "set the option ca_file to a PEM file of certificates";
    case Remedy::kCacheFolder:
      return "set the option cache_folder to another folder, or to NULL";
    case Remedy::kForeignCacheFolder:
      return "remove it, or set the option cache_folder to another folder, or to NULL";
  }
  return "";
}

void setLastError(const char* message, Remedy remedy) noexcept {
  try {
    lastError() = message;
    if (remedy != Remedy::kNone) lastError().append("; ").append(wordsFor(remedy));
  } catch (const std::exception&) {
    lastError().clear();
  }
}

}  // namespace lode::embed

using lode::embed::guard;

const char* lodestream_last_error() { return lode::embed::lastError().c_str(); }

void lodestream_default_options(lodestream_options* options) {
  if (options == nullptr) return;
  const lode::stream::StreamOptions of_stream;
  *options = {};
  options->memory_budget_bytes = of_stream.engine.memory_budget_bytes;
  options->triangle_budget = of_stream.engine.refine.triangle_budget;
  options->connect_timeout_ms = static_cast<uint32_t>(of_stream.connect_timeout.count());
  options->decode_threads = lode::stream::defaultDecodeThreads();
}

lodestream_stream* lodestream_open(const char* url, const lodestream_options* options) {
  lodestream_stream* stream = nullptr;
  guard([&] {
    if (url == nullptr)
      throw lode::Error(lode::ErrorCode::kUsage, "the url is NULL: pass lode://HOST[:PORT]/MODEL");
    lodestream_options chosen;
    lodestream_default_options(&chosen);
    if (options != nullptr) chosen = *options;
    stream = std::make_unique<lodestream_stream>(lode::stream::parseServedModel(url),
                                                 lode::embed::toStreamOptions(chosen))
                 .release();
  });
  return stream;
}

void lodestream_close(lodestream_stream* stream) { const std::unique_ptr<lodestream_stream> closed(stream); }

int lodestream_step(lodestream_stream* stream, uint32_t wait_ms, lodestream_status* status) {
  return guard([&] {
    lodestream_stream& of = lode::embed::streamAt(stream);
    lode::embed::given(status, "status");
    const lode::stream::StreamStatus now = of.streamer.waitForNews(std::chrono::milliseconds(wait_ms));
    if (!of.model) of.model = of.streamer.model();
    if (now.cut != of.cut) ++of.cut_serial;
    of.cut = now.cut;
    *status = lode::embed::toStatus(now, of);
    if (status->has_failed) lode::embed::setLastError(now.failure.c_str(), now.failure_remedy);
  });
}

int lodestream_describe(lodestream_stream* stream, lodestream_model* model) {
  return guard([&] {
    const lode::ModelSummary& summary = lode::embed::modelOf(lode::embed::streamAt(stream));
    lode::embed::given(model, "model") = {};
    lode::embed::copyTo(model->origin, summary.lattice.origin);
    if (!summary.box.empty()) {
      lode::embed::copyTo(model->box_min, summary.lattice.toWorld(summary.box.min));
      lode::embed::copyTo(model->box_max, summary.lattice.toWorld(summary.box.max));
    }
    model->triangles = summary.triangles;
    model->has_normals =
        summary.attributes.has(lode::AttributeSet::kNormal | lode::AttributeSet::kComputedNormal);
    model->has_colours = summary.attributes.has(lode::AttributeSet::kColour);
    model->has_textures = summary.textures && summary.textures.bytes > lode::kEmptyTextureSetBytes;
  });
}

int lodestream_set_view(lodestream_stream* stream, const lodestream_view* view) {
  return guard([&] {
    lodestream_stream& of = lode::embed::streamAt(stream);
    of.view = lode::embed::toView(lode::embed::given(view, "view"), lode::embed::modelOf(of));
    of.threshold_px = view->threshold_px;
    of.streamer.setView(*of.view, view->threshold_px);
  });
}

lodestream_cut* lodestream_take_cut(lodestream_stream* stream) {
  lodestream_cut* cut = nullptr;
  guard([&] {
    const lodestream_stream& of = lode::embed::streamAt(stream);
    if (!of.cut) return;
    cut = std::make_unique<lodestream_cut>(lodestream_cut{of.cut, lode::embed::modelOf(of), of.cut_serial})
              .release();
  });
  return cut;
}
