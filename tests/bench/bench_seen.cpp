// Counts bytes that a client receives until its picture looks right: bench_seen STORE... prints a row for
// each store and distance. A client without sockets always takes the best request, while the bytes of one
// round trip are in flight. Pictures are drawn off-screen. A small raster counts the visible pixels of each
// part.

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "client/core/cache/decode_job.h"
#include "client/core/lod/seen_places.h"
#include "client/core/lod/view_group.h"
#include "client/core/model.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/offscreen_context.h"
#include "client/render/renderer.h"
#include "server/store/reader.h"
#include "tests/bench/print_row.h"
#include "tests/bench/surface_cameras.h"

namespace lode::core {
namespace {

constexpr uint32_t kWidthPx = 1280, kHeightPx = 720;
constexpr float kThresholdPx = 1;
constexpr uint64_t kUnderWayBytes = 62'500;  // 50 ms at 10 Mbit/s
constexpr double kDifferingShare = 0.01;     // share of differing pixels in a picture that looks right
constexpr int kVisibleDifference = 8;        // visible difference of a channel, of 255
constexpr double kBetweenLooks = 1.01;       // factor of received bytes between two looks
constexpr int kCameras = 3;                  // number of cameras at each distance
struct Distance {
  const char* name;
  double diagonals;  // distance from the surface
};
constexpr Distance kDistances[] = {{"far", 2}, {"mid", 0.6}, {"near", 0.12}, {"close", 0.03}};

/// A cut, and the bytes received until it was published.
struct Look {
  uint64_t bytes = 0;
  size_t received = 0;  ///< number of requests
  std::shared_ptr<const Cut> cut;
};

/// A client of a store that refines one view until it has settled.
class Client {
 public:
  Client(const store::Reader& store, const View& view)
      : store_(store), model_(store.summary(), uint64_t{8} << 30) {
    group_.setView(view, kThresholdPx);
  }

  /// @return all published cuts; the last one has converged.
  std::vector<Look> looks() {
    std::vector<Look> looks;
    while (true) {
      group_.refine(model_);
      const std::shared_ptr<const Cut>& cut = group_.cut();
      const bool converged = cut && cut->converged;
      if (cut && (converged || looks.empty() ||
                  static_cast<double>(bytes_) > kBetweenLooks * static_cast<double>(looks.back().bytes)))
        looks.push_back({bytes_, received_.size(), cut});
      ask();
      if (converged || under_way_.empty()) return looks;
      take();
    }
  }
  /// Requests in their order of arrival.
  const std::vector<Request>& received() const { return received_; }

 private:
  void ask() {
    if (const auto first = model_.firstRequest()) ask(*first);
    for (const Request& request : group_.requests()) {
      if (under_way_bytes_ >= kUnderWayBytes) return;
      ask(request);
    }
  }
  void ask(const Request& request) {
    if (!model_.wants(request) || !asked_.insert(request.blob.number).second) return;
    under_way_.push_back(request);
    under_way_bytes_ += request.blob.bytes;
  }
  void take() {
    const Request request = under_way_.front();
    under_way_.pop_front();
    under_way_bytes_ -= request.blob.bytes;
    bytes_ += request.blob.bytes;
    received_.push_back(request);
    for (const Request& same : group_.requests())
      if (same.blob == request.blob && same.use != request.use)
        model_.take(same.blob, same.use, store_.readBlob(request.blob.number));
    model_.take(request.blob, request.use, store_.readBlob(request.blob.number));
    for (const DecodeJob& job : model_.takeDecodeJobs()) model_.finishDecode(runDecodeJob(job));
  }

  const store::Reader& store_;
  Model model_;
  ViewGroup group_;
  std::deque<Request> under_way_;
  std::vector<Request> received_;
  std::set<uint32_t> asked_;
  uint64_t under_way_bytes_ = 0, bytes_ = 0;
};

render::Image draw(render::Renderer& renderer, const render::Framebuffer& target, const Look& look) {
  renderer.show(look.cut);
  renderer.uploadInRenderThread({.wait = true});
  renderer.draw(look.cut->view, target);
  target.resolve();
  return target.readPixels();
}

double differingShare(const render::Image& a, const render::Image& b) {
  size_t differing = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    bool differs = false;
    for (size_t channel = 0; channel < 3; ++channel)
      differs |= std::abs(a.rgba[i + channel] - b.rgba[i + channel]) > kVisibleDifference;
    differing += differs;
  }
  return static_cast<double>(differing * 4) / static_cast<double>(a.rgba.size());
}

/// Finds by bisection the first cut whose picture looks right.
const Look& firstRight(const std::vector<Look>& looks, render::Renderer& renderer,
                       const render::Framebuffer& target) {
  const render::Image converged = draw(renderer, target, looks.back());
  size_t wrong = 0, right = looks.size() - 1;
  while (wrong < right) {
    const size_t middle = (wrong + right) / 2;
    if (differingShare(draw(renderer, target, looks[middle]), converged) <= kDifferingShare)
      right = middle;
    else
      wrong = middle + 1;
  }
  return looks[right];
}

/// Counts the pixels of each part of a cut in its view. Triangles that reach behind the near plane are
/// skipped.
class PixelCount {
 public:
  PixelCount(const Cut& cut, double step)
      : view_(cut.view),
        right_(glm::cross(cut.view.forward, cut.view.up)),
        focal_px_(kHeightPx / (2 * std::tan(cut.view.fov_y_rad / 2))),
        nearness_(size_t{kWidthPx} * kHeightPx),
        part_(nearness_.size(), cut.parts.size()),
        pixels_(cut.parts.size() + 1) {
    for (size_t i = 0; i < cut.parts.size(); ++i) {
      std::vector<glm::dvec3> places;
      for (const PositionCode& position : cut.parts[i].mesh->positions)
        places.push_back(see(glm::dvec3(unpackPosition(position)) * step));
      for (const glm::u32vec3& triangle : cut.parts[i].mesh->triangles)
        draw(i, places[triangle.x], places[triangle.y], places[triangle.z]);
    }
    for (const size_t part : part_) ++pixels_[part];
  }
  uint64_t of(size_t part) const { return pixels_[part]; }

 private:
  glm::dvec3 see(glm::dvec3 point) const {
    const glm::dvec3 arm = point - view_.eye_model;
    const double depth = glm::dot(arm, view_.forward);
    if (depth <= view_.near_model) return {0, 0, 0};
    return {kWidthPx / 2.0 + focal_px_ * glm::dot(arm, right_) / depth,
            kHeightPx / 2.0 + focal_px_ * glm::dot(arm, view_.up) / depth, 1 / depth};
  }
  void draw(size_t part, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    if (a.z == 0 || b.z == 0 || c.z == 0) return;
    const auto first = [](double least) { return std::max(0.0, std::ceil(least - 0.5)); };
    const auto last = [](double most, uint32_t side) { return std::min(side - 1.0, std::floor(most - 0.5)); };
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) return;
    for (double y = first(std::min({a.y, b.y, c.y})); y <= last(std::max({a.y, b.y, c.y}), kHeightPx); ++y)
      for (double x = first(std::min({a.x, b.x, c.x})); x <= last(std::max({a.x, b.x, c.x}), kWidthPx); ++x) {
        const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
        const double of_b = (px * (c.y - a.y) - py * (c.x - a.x)) / area;
        const double of_c = ((b.x - a.x) * py - (b.y - a.y) * px) / area;
        if (of_b < 0 || of_c < 0 || of_b + of_c > 1) continue;
        const size_t pixel = static_cast<size_t>(y) * kWidthPx + static_cast<size_t>(x);
        const double nearness = a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z);
        if (nearness <= nearness_[pixel]) continue;
        nearness_[pixel] = nearness;
        part_[pixel] = part;
      }
  }

  const View view_;
  const glm::dvec3 right_;
  const double focal_px_;
  std::vector<double> nearness_;
  std::vector<size_t> part_;
  std::vector<uint64_t> pixels_;
};

/// Sums over all cameras, in bytes unless the name says otherwise.
struct Shares {
  uint64_t until_right = 0, seen = 0, hidden = 0, outside = 0, replaced = 0, cut = 0;
  /// Bytes of the parts of the converged cut that show this share of the pixels, parts with most pixels per
  /// byte first.
  uint64_t floor = 0;
  uint64_t parts = 0, seen_parts = 0;
  uint64_t mistaken_parts = 0,
           mistaken_pixels = 0;  ///< visible parts that an earlier estimate took for hidden
};

/// Adds the visible parts of the converged cut that a coarser cut takes for hidden. Uses the coarser cut with
/// most such parts.
void addMistakes(Shares& shares, const std::vector<Look>& looks, const PixelCount& pixels,
                 const ModelSummary& model) {
  const std::vector<CutPart>& parts = looks.back().cut->parts;
  uint64_t most_parts = 0, most_pixels = 0;
  for (const Look& look : looks) {
    if (look.cut->triangles > SeenPlaces::kMostTriangles) break;
    const std::optional<SeenPlaces> seen = SeenPlaces::of(*look.cut, model);
    uint64_t mistaken = 0, of_pixels = 0;
    for (size_t i = 0; seen && i < parts.size(); ++i) {
      if (pixels.of(i) == 0 || seen->in(parts[i].node)) continue;
      ++mistaken;
      of_pixels += pixels.of(i);
    }
    most_parts = std::max(most_parts, mistaken);
    most_pixels = std::max(most_pixels, of_pixels);
  }
  shares.mistaken_parts += most_parts;
  shares.mistaken_pixels += most_pixels;
}

void add(Shares& shares, const store::Reader& store, const Look& right, const std::vector<Request>& received,
         const std::vector<Look>& looks) {
  const Cut& converged = *looks.back().cut;
  const PixelCount pixels(converged, store.summary().lattice.step);
  addMistakes(shares, looks, pixels, store.summary());
  struct Part {
    uint64_t bytes, pixels;
    bool visible;
  };
  std::map<MeshKey, Part> parts;
  std::vector<Part> by_worth;
  uint64_t all_pixels = 0;
  for (size_t i = 0; i < converged.parts.size(); ++i) {
    const CutPart& part = converged.parts[i];
    const Part seen{store.find(part.node)->lods[part.lod].payload.bytes, pixels.of(i), part.visible};
    parts[{part.node, part.lod}] = seen;
    by_worth.push_back(seen);
    all_pixels += seen.pixels;
    shares.cut += seen.bytes;
    shares.seen_parts += seen.pixels > 0;
  }
  shares.parts += parts.size();
  std::ranges::sort(by_worth,
                    [](const Part& a, const Part& b) { return a.pixels * b.bytes > b.pixels * a.bytes; });
  uint64_t shown = 0;
  for (const Part& part : by_worth) {
    if (static_cast<double>(all_pixels - shown) <= kDifferingShare * kWidthPx * kHeightPx) break;
    shown += part.pixels;
    shares.floor += part.bytes;
  }
  shares.until_right += right.bytes;
  for (size_t i = 0; i < right.received; ++i) {
    const Request& request = received[i];
    const auto part = parts.find(request.use.mesh);
    if (request.use.kind != BlobKind::kMesh) continue;  // a page
    if (part == parts.end())
      shares.replaced += request.blob.bytes;
    else
      (part->second.pixels > 0 ? shares.seen
       : part->second.visible  ? shares.hidden
                               : shares.outside) += request.blob.bytes;
  }
}

void measure(const std::string& file) {
  const store::Reader store(file);
  bench::SurfaceCameras cameras(store, kWidthPx, kHeightPx);
  render::Renderer renderer(store.summary().lattice.step);
  const render::Framebuffer target(kWidthPx, kHeightPx, 1);
  for (const Distance& distance : kDistances) {
    Shares shares;
    for (int camera = 0; camera < kCameras; ++camera) {
      Client client(store, cameras.next(distance.diagonals));
      const std::vector<Look> looks = client.looks();
      add(shares, store, firstRight(looks, renderer, target), client.received(), looks);
    }
    const auto mean = [](uint64_t count) { return static_cast<double>(count) / kCameras; };
    bench::printRow({{"model", std::filesystem::path(file).stem().string()},
                     {"distance", distance.name},
                     {"until_right_kb", mean(shares.until_right) / 1e3},
                     {"seen_kb", mean(shares.seen) / 1e3},
                     {"hidden_kb", mean(shares.hidden) / 1e3},
                     {"outside_kb", mean(shares.outside) / 1e3},
                     {"replaced_kb", mean(shares.replaced) / 1e3},
                     {"final_cut_kb", mean(shares.cut) / 1e3},
                     {"floor_kb", mean(shares.floor) / 1e3},
                     {"seen_parts", mean(shares.seen_parts)},
                     {"parts", mean(shares.parts)},
                     {"mistaken_parts", mean(shares.mistaken_parts)},
                     {"mistaken_percent", 100 * mean(shares.mistaken_pixels) / kWidthPx / kHeightPx}});
  }
}

}  // namespace
}  // namespace lode::core

int main(int argc, char** argv) {
  const lode::render::OffscreenContext context;
  for (int i = 1; i < argc; ++i) lode::core::measure(argv[i]);
}
