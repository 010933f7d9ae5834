// Of a Renderer what is drawn by commands that the GPU has written.

#include "client/render/renderer.h"

namespace lode::render {

DrawCounts Renderer::addInstance(size_t number, const core::View& view, const DrawStyle& style,
                                 const DrawTime& time, GpuCulling& culling) {
  DrawnInstance& instance = choose(number, view, time);
  DrawCounts counts = collect(instance, view, style, true);
  for (const SeenPart& part : instance.parts)
    countShown(instance, part, part.item->index_count / 3, view, counts);
  instance.number = culling.add(instance.parts, meshes_.pages(), lattice_step_, view, instance.last_view);
  instance.last_view = view;
  return counts;
}

uint32_t Renderer::drawFound(size_t number, const core::View& view, const Framebuffer& target,
                             const DrawStyle& style, const GpuCulling& culling) {
  const DrawnInstance& instance = instances_[number];
  const std::span<const GpuCulling::Draw> draws = culling.draws(instance.number);
  if (draws.empty()) return 0;
  has_samples_ = target.samples() > 1;
  drawer_.begin(instance.states_buffer, instance.parts.front().item->attributes, textures_);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, culling.commands());
  glBindBuffer(GL_PARAMETER_BUFFER, culling.counts());
  std::optional<bool> fades;
  for (const GpuCulling::Draw& draw : draws) {
    if (fades != draw.fades) drawer_.use(draw.fades, has_samples_, view, lattice_step_, style);
    fades = draw.fades;
    drawer_.bindPage(meshes_.pages(), draw.page);
    const uint64_t first = culling.firstCommandOfPass() + draw.first_command;
    const uint64_t count = culling.firstCountOfPass() + draw.count;
    glMultiDrawElementsIndirectCount(GL_TRIANGLES, GL_UNSIGNED_INT,
                                     reinterpret_cast<const void*>(first * sizeof(DrawCommand)),
                                     static_cast<GLintptr>(count * sizeof(uint32_t)),
                                     static_cast<GLsizei>(draw.most_commands), sizeof(DrawCommand));
  }
  glBindBuffer(GL_PARAMETER_BUFFER, 0);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  drawer_.end();
  return static_cast<uint32_t>(draws.size());
}

}  // namespace lode::render
