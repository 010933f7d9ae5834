// Draws of a Renderer whose commands the GPU has written.

#include "client/render/renderer.h"

namespace lode::render {

void Renderer::drawUnhiddenOnGpu(Place& place, const core::View& view, const DrawStyle& style,
                                 const DepthPyramid& last_drawn, DrawCounts& counts) {
  if (!culling_programs_) culling_programs_.emplace();
  if (!place.culling) place.culling = std::make_unique<GpuCulling>();
  place.culling->begin(place.parts, lattice_step_);
  place.culling->findUnhidden(*culling_programs_, meshes_.pages(), view, place.last_view, last_drawn);
  place.last_view = view;
  for (const SeenPart& part : place.parts) countShown(place, part, part.item->index_count / 3, view, counts);
  counts.triangles += place.culling->trianglesLately();
  counts.calls += drawFound(place, view, style);
}

DrawCounts Renderer::drawAppeared(size_t number, const core::View& view, const Framebuffer& target,
                                  const DrawStyle& style, const DepthPyramid& drawn) {
  DrawCounts counts;
  const Place& place = places_[number];
  if (!place.last_view) return counts;  // all was drawn
  target.bindForDrawing();
  place.culling->findAppeared(*culling_programs_, meshes_.pages(), view, drawn);
  counts.calls = drawFound(place, view, style);
  return counts;
}

/// @return draw calls.
uint32_t Renderer::drawFound(const Place& place, const core::View& view, const DrawStyle& style) {
  const GpuCulling& found = *place.culling;
  if (found.draws().empty()) return 0;
  drawer_.begin(place.states, place.parts.front().item->attributes, textures_);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, found.commands());
  glBindBuffer(GL_PARAMETER_BUFFER, found.counts());
  const bool* fades = nullptr;
  uint32_t number = found.firstCountOfPass();
  for (const GpuCulling::Draw& draw : found.draws()) {
    if (fades == nullptr || *fades != draw.fades)
      drawer_.use(draw.fades, has_samples_, view, lattice_step_, style);
    fades = &draw.fades;
    drawer_.bindPage(meshes_.pages(), draw.page);
    const uint64_t first = found.firstCommandOfPass() + draw.first_command;
    glMultiDrawElementsIndirectCount(GL_TRIANGLES, GL_UNSIGNED_INT,
                                     reinterpret_cast<const void*>(first * sizeof(DrawCommand)),
                                     static_cast<GLintptr>(number * sizeof(uint32_t)),
                                     static_cast<GLsizei>(draw.most_commands), sizeof(DrawCommand));
    ++number;
  }
  glBindBuffer(GL_PARAMETER_BUFFER, 0);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  drawer_.end();
  return static_cast<uint32_t>(found.draws().size());
}

}  // namespace lode::render
