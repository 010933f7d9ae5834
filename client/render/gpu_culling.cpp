#include "client/render/gpu_culling.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "client/render/culling_shaders.h"
#include "client/render/draw_list.h"
#include "client/render/eye.h"
#include "client/render/occluders.h"
#include "client/render/shader_program.h"

namespace lode::render {
namespace {

enum FindUniform : GLint {
  kFirstChunk,
  kPass,
  kChunksOfPass,
  kCullLatticeStep,
  kDepthSizePx,
  kDepthCamera,
  kCullEyeHigh,
  kCullEyeLow = kCullEyeHigh + 2,
  kCullRotation = kCullEyeLow + 2,
  kCullProjection = kCullRotation + 2
};
enum ListUniform : GLint { kListPass, kListChunksOfPass, kCommandsOfPass, kListsOfPass, kTrianglesPlace };
enum Storage : GLuint { kPage = 1, kChunks, kFound, kLists, kCommands, kCounts, kTriangles };
constexpr GLuint kPyramidUnit = 1;
constexpr int kNow = 0, kBefore = 1, kNever = -1;  ///< cameras
constexpr uint32_t kChunkClusters = 64;
constexpr uint32_t kPasses = 2;

template <typename Element>
void give(const GlBuffer& buffer, const std::vector<Element>& elements) {
  glNamedBufferData(buffer.get(), static_cast<GLsizeiptr>(elements.size() * sizeof(Element)), elements.data(),
                    GL_STREAM_DRAW);
}

void makeRoom(const GlBuffer& buffer, size_t bytes) {
  glNamedBufferData(buffer.get(), static_cast<GLsizeiptr>(std::max<size_t>(bytes, 4)), nullptr,
                    GL_STREAM_COPY);
}

void bind(Storage place, const GlBuffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, place, buffer.get());
}

void setCamera(int number, const core::View& view, double lattice_step) {
  const SplitEye eye = splitEye(view.eye_model, lattice_step);
  const glm::mat3 rotation = viewRotation(view);
  const Projection projection = reversedProjection(view, lattice_step);
  glUniform3iv(kCullEyeHigh + number, 1, glm::value_ptr(eye.high));
  glUniform3fv(kCullEyeLow + number, 1, glm::value_ptr(eye.low));
  glUniformMatrix3fv(kCullRotation + number, 1, GL_FALSE, glm::value_ptr(rotation));
  glUniform3f(kCullProjection + number, projection.scale.x, projection.scale.y, projection.near_model);
}

}  // namespace

CullingPrograms::CullingPrograms()
    : find(linkComputeProgram(kFindShader)), list(linkComputeProgram(kListShader)) {}

GpuCulling::GpuCulling()
    : chunks_buffer_(GlBuffer::create()),
      lists_buffer_(GlBuffer::create()),
      found_(GlBuffer::create()),
      commands_(GlBuffer::create()),
      counts_(GlBuffer::create()),
      triangles_(GlBuffer::create()) {
  constexpr GLbitfield kKept = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  constexpr std::array<uint32_t, kFramesKept> kNothing{};
  glNamedBufferStorage(triangles_.get(), sizeof(kNothing), kNothing.data(), kKept | GL_CLIENT_STORAGE_BIT);
  triangles_told_ =
      static_cast<const uint32_t*>(glMapNamedBufferRange(triangles_.get(), 0, sizeof(kNothing), kKept));
}

GpuCulling::~GpuCulling() {
  if (triangles_told_ != nullptr) glUnmapNamedBuffer(triangles_.get());
}

bool GpuCulling::isPossible(uint64_t page_bytes) {
  static_assert(kTriangles < 8);  // of which every context has as many
  GLint64 most_bytes = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most_bytes);
  const bool counts = epoxy_gl_version() >= 46 || epoxy_has_gl_extension("GL_ARB_indirect_parameters");
  return counts && static_cast<uint64_t>(most_bytes) >= page_bytes;
}

void GpuCulling::begin(std::span<const SeenPart> parts, double lattice_step) {
  lattice_step_ = lattice_step;
  frame_ = (frame_ + 1) % kFramesKept;
  chunks_.clear();
  lists_.clear();
  draws_.clear();
  most_commands_ = 0;
  std::vector<const SeenPart*> ordered;
  for (const SeenPart& part : parts) ordered.push_back(&part);
  std::ranges::stable_sort(ordered, {},
                           [](const SeenPart* part) { return std::pair(part->fades, part->item->page); });
  for (const SeenPart* const part : ordered) {
    if (draws_.empty() || draws_.back().fades != part->fades || draws_.back().page != part->item->page) {
      draws_.push_back({part->fades, part->item->page, most_commands_, 0});
      lists_.push_back({static_cast<uint32_t>(chunks_.size()), 0, most_commands_});
    }
    addChunks(*part);
  }
  give(chunks_buffer_, chunks_);
  give(lists_buffer_, lists_);
  makeRoom(found_, kPasses * chunks_.size() * sizeof(uint64_t));
  makeRoom(commands_, kPasses * most_commands_ * sizeof(DrawCommand));
  makeRoom(counts_, kPasses * draws_.size() * sizeof(uint32_t));
  glClearNamedBufferSubData(triangles_.get(), GL_R32UI, frame_ * sizeof(uint32_t), sizeof(uint32_t),
                            GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
}

void GpuCulling::addChunks(const SeenPart& part) {
  constexpr uint32_t kBoxWords = sizeof(LatticeBox) / sizeof(uint32_t);
  constexpr uint32_t kChunkIndices = 3 * kClusterTriangles * kChunkClusters;
  const DrawItem& item = *part.item;
  const auto clusters = static_cast<uint32_t>(item.clusters->boxes.size());
  for (uint32_t first = 0; first < clusters; first += kChunkClusters) {
    const uint32_t count = std::min(kChunkClusters, clusters - first);
    const uint32_t indices_before = first / kChunkClusters * kChunkIndices;
    chunks_.push_back({item.first_box_word + first * kBoxWords, count, item.first_index + indices_before,
                       std::min(kChunkIndices, item.index_count - indices_before),
                       static_cast<int32_t>(item.base_vertex), part.state});
    ++lists_.back().chunks;
    draws_.back().most_commands += (count + 1) / 2;  // each but the last is followed by what is left out
    most_commands_ += (count + 1) / 2;
  }
}

void GpuCulling::findUnhidden(const CullingPrograms& programs, const GpuPages& pages, const core::View& view,
                              const std::optional<core::View>& last, const DepthPyramid& last_drawn) {
  pass_ = 0;
  find(programs, pages, view, last ? &*last : nullptr, last_drawn);
}

void GpuCulling::findAppeared(const CullingPrograms& programs, const GpuPages& pages, const core::View& view,
                              const DepthPyramid& drawn) {
  pass_ = 1;
  find(programs, pages, view, &view, drawn);
}

/// @param depth_view  what the depths are of; null: nothing hides.
void GpuCulling::find(const CullingPrograms& programs, const GpuPages& pages, const core::View& view,
                      const core::View* depth_view, const DepthPyramid& depths) {
  if (draws_.empty()) return;
  const auto chunks = static_cast<GLuint>(chunks_.size());
  bind(kChunks, chunks_buffer_);
  bind(kFound, found_);
  bind(kLists, lists_buffer_);
  bind(kCommands, commands_);
  bind(kCounts, counts_);
  bind(kTriangles, triangles_);
  const bool hides = depth_view != nullptr && depths.widthPx() > 0;
  if (hides) glBindTextureUnit(kPyramidUnit, depths.texture());
  glUseProgram(programs.find.get());
  glUniform1ui(kPass, pass_);
  glUniform1ui(kChunksOfPass, chunks);
  glUniform1f(kCullLatticeStep, static_cast<float>(lattice_step_));
  glUniform2f(kDepthSizePx, static_cast<float>(depths.widthPx()), static_cast<float>(depths.heightPx()));
  glUniform1i(kDepthCamera, !hides ? kNever : depth_view == &view ? kNow : kBefore);
  setCamera(kNow, view, lattice_step_);
  setCamera(kBefore, hides ? *depth_view : view, lattice_step_);
  for (size_t i = 0; i < draws_.size(); ++i) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kPage, pages.buffer(draws_[i].page));
    glUniform1ui(kFirstChunk, lists_[i].first_chunk);
    glDispatchCompute(lists_[i].chunks, 1, 1);
  }
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glUseProgram(programs.list.get());
  glUniform1ui(kListPass, pass_);
  glUniform1ui(kListChunksOfPass, chunks);
  glUniform1ui(kCommandsOfPass, most_commands_);
  glUniform1ui(kListsOfPass, static_cast<GLuint>(lists_.size()));
  glUniform1ui(kTrianglesPlace, frame_);
  glDispatchCompute(static_cast<GLuint>(lists_.size()), 1, 1);
  glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
}

uint64_t GpuCulling::trianglesLately() const noexcept {
  const volatile uint32_t* const told = triangles_told_;
  return told == nullptr ? 0 : told[(frame_ + 1) % kFramesKept];
}

}  // namespace lode::render
