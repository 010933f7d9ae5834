#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <emscripten.h>

#include "client/render/residency/gpu_vertex.h"
#include "client/web/core/es_shaders.h"
#include "client/web/core/page_json.h"
#include "client/web/core/web_model.h"
#include "common/codec/texture_set.h"

/// The functions of the WebAssembly module (docs/browser.md). A text or byte array is passed as pointer and
/// length. A function stores a result that is no number as the answer, which lode_answer() returns until the
/// next call.
namespace {

using namespace lode;

struct Opened {
  web::WebModel model;
  uint64_t known_serial = ~uint64_t{0};  // serial of the list of parts that the page knows
  web::FrameInput frame;
};

std::map<int, std::unique_ptr<Opened>> models;
int last_handle = 0;
web::Bytes answer;

core::TimePoint at(double now_ms) {
  // Adds a second, so that no time is 0: the page's clock starts at 0.
  const std::chrono::duration<double, std::milli> since_zero(now_ms + 1000);
  return core::TimePoint{} + std::chrono::duration_cast<core::TimePoint::duration>(since_zero);
}

std::string_view textOf(const char* text, int bytes) { return {text, static_cast<size_t>(bytes)}; }

std::span<const std::byte> bytesOf(const uint8_t* bytes, int count) {
  return std::as_bytes(std::span(bytes, static_cast<size_t>(count)));
}

int answerWith(web::Bytes bytes) {
  answer = std::move(bytes);
  return static_cast<int>(answer.size());
}

int answerWith(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  answer.assign(bytes.begin(), bytes.end());
  return static_cast<int>(answer.size());
}

Opened& opened(int handle) { return *models.at(handle); }

/// Calls a function. @return its result; 1 after an exception, with its message as answer.
template <typename Call>
int guarded(const Call& call) {
  try {
    return call();
  } catch (const std::bad_alloc&) {
    answerWith(
        web::errorJson("the browser gives this page no more memory; choose a smaller memory budget", true));
  } catch (const std::exception& error) {
    answerWith(web::errorJson(error.what(), true));
  }
  return 1;
}

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE const std::byte* lode_answer() { return answer.data(); }
EMSCRIPTEN_KEEPALIVE int lode_answer_bytes() { return static_cast<int>(answer.size()); }

EMSCRIPTEN_KEEPALIVE int lode_open(const char* json, int bytes) {
  int handle = 0;
  guarded([&] {
    auto model = std::make_unique<Opened>(Opened{web::WebModel(web::parseOptions(textOf(json, bytes)))});
    handle = ++last_handle;
    models.emplace(handle, std::move(model));
    return 0;
  });
  return handle;
}

EMSCRIPTEN_KEEPALIVE void lode_close(int handle) { models.erase(handle); }

EMSCRIPTEN_KEEPALIVE int lode_wants_connection(int handle, double now_ms) {
  return opened(handle).model.engine().wantsConnection(at(now_ms)) ? 1 : 0;
}

EMSCRIPTEN_KEEPALIVE void lode_connect(int handle, double now_ms) {
  opened(handle).model.engine().connect(at(now_ms));
}

EMSCRIPTEN_KEEPALIVE int lode_connected(int handle) {
  return opened(handle).model.engine().connected() ? 1 : 0;
}

/// @return 1 if the model cannot be reached at all.
EMSCRIPTEN_KEEPALIVE int lode_disconnect(int handle, const char* why, int bytes, double now_ms) {
  return guarded([&] {
    opened(handle).model.engine().disconnect(Error(ErrorCode::kNetwork, std::string(textOf(why, bytes))),
                                             at(now_ms));
    return 0;
  });
}

/// Takes received bytes. After an error of the connection, disconnects, and the engine reconnects later.
EMSCRIPTEN_KEEPALIVE int lode_receive(int handle, const uint8_t* bytes, int count, double now_ms) {
  return guarded([&] {
    core::Engine& engine = opened(handle).model.engine();
    try {
      engine.receive(bytesOf(bytes, count), at(now_ms));
    } catch (const Error& error) {
      engine.disconnect(error, at(now_ms));
    }
    return 0;
  });
}

EMSCRIPTEN_KEEPALIVE int lode_takes_input(int handle) {
  return opened(handle).model.engine().takesInput() ? 1 : 0;
}

EMSCRIPTEN_KEEPALIVE int lode_step(int handle, double now_ms) {
  return guarded([&] {
    opened(handle).model.engine().step(at(now_ms));
    return 0;
  });
}

EMSCRIPTEN_KEEPALIVE int lode_take_outgoing(int handle) {
  return answerWith(opened(handle).model.engine().takeOutgoing());
}

EMSCRIPTEN_KEEPALIVE int lode_take_job(int handle) {
  std::optional<web::Bytes> job = opened(handle).model.takeJob();
  return job ? answerWith(std::move(*job)) : 0;
}

EMSCRIPTEN_KEEPALIVE int lode_finish_job(int handle, const uint8_t* bytes, int count) {
  return guarded([&] {
    opened(handle).model.finishJob(bytesOf(bytes, count));
    return 0;
  });
}

EMSCRIPTEN_KEEPALIVE int lode_take_cache_query(int handle) {
  const std::optional<BlobRef> query = opened(handle).model.takeCacheQuery();
  if (!query) return 0;
  return answerWith("{\"number\":" + std::to_string(query->number) + ",\"digest\":\"" + toHex(query->digest) +
                    "\",\"bytes\":" + std::to_string(query->bytes) + "}");
}

/// @param count  -1 if the cache does not have the blob.
EMSCRIPTEN_KEEPALIVE void lode_finish_cache_query(int handle, unsigned number, const uint8_t* bytes,
                                                  int count) {
  guarded([&] {
    opened(handle).model.finishCacheQuery(number,
                                          count < 0 ? std::nullopt : std::optional(bytesOf(bytes, count)));
    return 0;
  });
}

EMSCRIPTEN_KEEPALIVE int lode_take_arrival(int handle) {
  const std::optional<core::Engine::Arrival> arrival = opened(handle).model.takeArrival();
  if (!arrival) return 0;
  const std::string digest = toHex(arrival->blob.digest);
  const auto name = std::as_bytes(std::span(digest));
  web::Bytes bytes(name.begin(), name.end());
  bytes.insert(bytes.end(), arrival->bytes.begin(), arrival->bytes.end());
  return answerWith(std::move(bytes));
}

/// Answers with the image file if the job is a tile of a texture.
EMSCRIPTEN_KEEPALIVE int lode_job_image(const uint8_t* message, int count) {
  int is_image = 0;
  guarded([&] {
    web::JobMessage job = web::decodeJob(bytesOf(message, count));
    is_image = job.job.use.kind == core::BlobKind::kTile ? 1 : 0;
    if (is_image != 0) answerWith(std::move(job.job.bytes));
    return 0;
  });
  return is_image;
}

EMSCRIPTEN_KEEPALIVE int lode_decode_image(const uint8_t* message, int count, const uint8_t* texels,
                                           unsigned width, unsigned height) {
  guarded([&] {
    const web::JobMessage job = web::decodeJob(bytesOf(message, count));
    const std::span texel_bytes(texels, size_t{width} * height * 4);
    return answerWith(web::encodeResult(job.number, web::takeImage(job.job, texel_bytes, {width, height})));
  });
  return static_cast<int>(answer.size());
}

EMSCRIPTEN_KEEPALIVE int lode_decode(const uint8_t* message, int count) {
  guarded([&] {
    const web::JobMessage job = web::decodeJob(bytesOf(message, count));
    return answerWith(web::encodeResult(job.number, core::runDecodeJob(job.job)));
  });
  return static_cast<int>(answer.size());
}

EMSCRIPTEN_KEEPALIVE int lode_summary(int handle) {
  const ModelSummary* const summary = opened(handle).model.engine().summary();
  return summary == nullptr ? 0 : answerWith(web::summaryJson(*summary));
}

/// @return 1 once the camera is set; 0: call again; -1 after an error.
EMSCRIPTEN_KEEPALIVE int lode_start_camera(int handle, const char* json, int bytes) {
  int is_set = -1;
  guarded([&] {
    is_set = opened(handle).model.startCamera(web::parseCameraStart(textOf(json, bytes))) ? 1 : 0;
    return 0;
  });
  return is_set;
}

/// Answers with the frame, or an error.
EMSCRIPTEN_KEEPALIVE int lode_frame(int handle, double /*now_ms*/, const char* json, int bytes) {
  guarded([&] {
    Opened& shown = opened(handle);
    shown.frame = web::parseFrame(textOf(json, bytes));
    shown.model.frame(shown.frame);
    const bool is_new = shown.known_serial != shown.model.serial();
    shown.known_serial = shown.model.serial();
    return answerWith(web::frameJson(shown.model, shown.frame, is_new));
  });
  return static_cast<int>(answer.size());
}

EMSCRIPTEN_KEEPALIVE int lode_mesh_stride(int handle, unsigned id) {
  const std::shared_ptr<const Mesh> mesh = opened(handle).model.mesh(id);
  return mesh ? static_cast<int>(render::vertexBytes(mesh->attributes) / sizeof(uint32_t)) : 0;
}

EMSCRIPTEN_KEEPALIVE int lode_mesh_vertices(int handle, unsigned id) {
  const std::shared_ptr<const Mesh> mesh = opened(handle).model.mesh(id);
  if (!mesh) return 0;
  web::Bytes bytes(mesh->positions.size() * render::vertexBytes(mesh->attributes));
  render::packVertices(*mesh, 0, bytes);
  return answerWith(std::move(bytes));
}

EMSCRIPTEN_KEEPALIVE int lode_mesh_indices(int handle, unsigned id) {
  const std::shared_ptr<const Mesh> mesh = opened(handle).model.mesh(id);
  if (!mesh) return 0;
  const auto bytes = std::as_bytes(std::span(mesh->triangles));
  return answerWith(web::Bytes(bytes.begin(), bytes.end()));
}

/// Answers with the number of layers of the texture array and the size of the table of tiles in words. When
/// "serial" changes, the array is new and empty. @return 0 without textures.
EMSCRIPTEN_KEEPALIVE int lode_textures(int handle) {
  web::WebModel& model = opened(handle).model;
  if (!model.tiles().set()) return 0;
  return answerWith("{\"serial\":" + std::to_string(model.tiles().tableSerial()) +
                    ",\"layers\":" + std::to_string(model.tileLayers()) +
                    ",\"table_words\":" + std::to_string(model.tiles().table().size()) +
                    ",\"has_clear\":" + (model.tiles().hasClear() ? "true" : "false") + "}");
}

/// Answers with the words of the table of tiles. @return 0 if no word has changed since the last call.
EMSCRIPTEN_KEEPALIVE int lode_texture_table(int handle) {
  render::TilePlacement& tiles = opened(handle).model.tiles();
  if (tiles.takeChangedWords().empty()) return 0;
  const auto bytes = std::as_bytes(std::span(tiles.table()));
  return answerWith(web::Bytes(bytes.begin(), bytes.end()));
}

/// Answers with the next image to copy to the texture array: layer, x, y, width and height as words, then
/// rows of RGBA texels.
EMSCRIPTEN_KEEPALIVE int lode_take_texture_upload(int handle) {
  const std::optional<web::WebModel::TileUpload> upload = opened(handle).model.takeTileUpload();
  if (!upload) return 0;
  const TileImage& image = *upload->image;
  const std::array<uint32_t, 5> place{upload->cell.layer, upload->cell.corner.x, upload->cell.corner.y,
                                      image.size.x, image.size.y};
  const auto head = std::as_bytes(std::span(place));
  const auto texels = std::as_bytes(std::span(image.texels));
  web::Bytes bytes(head.begin(), head.end());
  bytes.insert(bytes.end(), texels.begin(), texels.end());
  return answerWith(std::move(bytes));
}

/// Answers with the point at a pixel, or an error. @return 0 if there is no surface.
EMSCRIPTEN_KEEPALIVE int lode_pick(int handle, double x_px, double y_px) {
  answer.clear();
  guarded([&] {
    const std::optional<web::WebPick> pick = opened(handle).model.pick({x_px, y_px});
    return pick ? answerWith(web::pickJson(*pick)) : 0;
  });
  return static_cast<int>(answer.size());
}

/// Answers with pixels, or an error.
EMSCRIPTEN_KEEPALIVE int lode_project(int handle, const char* json, int bytes) {
  guarded([&] { return answerWith(web::projectJson(opened(handle).model, textOf(json, bytes))); });
  return static_cast<int>(answer.size());
}

/// Answers with a shader of the mesh program. @param stage  0: vertex, 1: fragment.
/// @param parts  sum of 1: textured, 2: cut out, 4: a colour mode other than surface, 8: wireframe.
EMSCRIPTEN_KEEPALIVE int lode_shader(int stage, int parts) {
  const web::EsShaders shaders = web::esShaders({.textured = (parts & 1) != 0,
                                                 .cut_out = (parts & 2) != 0,
                                                 .views = (parts & 4) != 0,
                                                 .wire = (parts & 8) != 0});
  return answerWith(stage == 0 ? shaders.vertex : shaders.fragment);
}

}  // extern "C"
