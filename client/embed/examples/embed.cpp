// Streams a model until its error is at most one pixel. Then prints the number of triangles per octree level.
//
//   embed lode://HOST[:PORT]/MODEL

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <map>

#include <lodestream.h>

namespace {

/// Returns a view of the model's box from the front and slightly above. The box fills the picture.
lodestream::View frame(const lodestream::Model& model) {
  lodestream::View view{};
  double radius = 0;
  for (int axis = 0; axis < 3; ++axis) {
    view.target[axis] = (model.box_min[axis] + model.box_max[axis]) / 2;
    radius += std::pow((model.box_max[axis] - model.box_min[axis]) / 2, 2);
  }
  radius = std::sqrt(radius);
  view.eye[0] = view.target[0];
  view.eye[1] = view.target[1] + radius;
  view.eye[2] = view.target[2] + 2.5 * radius;
  view.up[1] = 1;
  view.fov_y_deg = 45;
  view.width_px = 1280;
  view.height_px = 720;
  view.threshold_px = 1;
  return view;
}

/// Checks the indices of a mesh. A renderer would upload the mesh instead.
bool isSound(const lodestream::Mesh& mesh) {
  return std::all_of(mesh->indices, mesh->indices + size_t{3} * mesh->triangles,
                     [&](uint32_t index) { return index < mesh->vertices; });
}

int depthOf(uint64_t node) { return (static_cast<int>(std::bit_width(node)) - 1) / 3; }

void walk(const lodestream::Cut& cut, const lodestream::View& view) {
  std::map<int, uint64_t> triangles_at;
  uint64_t unseen = 0;
  for (const size_t i : cut.shown(view)) {
    const lodestream::Part part = cut.part(i);
    if (!isSound(cut.mesh(i)))
      std::printf("node %llu is damaged\n", static_cast<unsigned long long>(part.node));
    triangles_at[depthOf(part.node)] += part.triangles;
    unseen += part.is_visible ? 0 : part.triangles;
  }
  std::printf("%llu triangles in %zu parts, %llu of them out of the picture, largest error %.2f pixels\n",
              static_cast<unsigned long long>(cut->triangles), cut->parts,
              static_cast<unsigned long long>(unseen), static_cast<double>(cut->max_error_px));
  for (const auto& [depth, triangles] : triangles_at)
    std::printf("  level %d: %llu triangles\n", depth, static_cast<unsigned long long>(triangles));
}

void run(const char* url) {
  lodestream::Stream stream(url);
  while (!stream.step(1000).is_open) {
  }
  const lodestream::View view = frame(stream.describe());
  stream.setView(view);

  // A game would instead step once per frame without waiting, and draw the cut.
  lodestream::Status status{};
  uint64_t drawn_serial = 0;
  while (!status.is_settled && !status.has_ended) {
    status = stream.step(1000);
    if (status.cut_serial == drawn_serial) continue;
    drawn_serial = status.cut_serial;
    const lodestream::Cut cut = stream.takeCut();
    std::fprintf(stderr, "%zu parts, %.2f pixels\n", cut->parts, static_cast<double>(cut->max_error_px));
  }
  if (status.has_ended) throw lodestream::Error(lodestream_last_error());
  walk(stream.takeCut(), view);
  std::printf("%llu bytes received\n", static_cast<unsigned long long>(status.received_bytes));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: embed lode://HOST[:PORT]/MODEL\n");
    return 2;
  }
  try {
    run(arguments[1]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "embed: %s\n", error.what());
    return 1;
  }
}
