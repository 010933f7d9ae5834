#include "client/render/culling/gpu_culling.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "client/render/culling/cluster_culling.h"
#include "client/render/culling/culling_shaders.h"
#include "client/render/gl/eye.h"
#include "client/render/gl/shader_program.h"

namespace lode::render {
namespace {

enum FindUniform : GLint { kFindPass, kFindChunks, kFirstChunk, kHasBoxes, kDepthSizePx };
enum ListUniform : GLint { kListPass, kListChunks, kListCommands, kListLists, kTrianglesPlace, kFirstList };
enum Storage : GLuint {
  kPage = 1,
  kChunks,
  kFound,
  kCameras,
  kLists = kCameras,
  kCommands,
  kCounts,
  kTriangles
};
constexpr GLuint kPyramidUnit = 1;
constexpr uint32_t kChunkClusters = 64;      ///< number of threads in a work group of kFindShader
constexpr uint32_t kMostWorkGroups = 65535;  ///< number of work groups per dispatch that OpenGL guarantees
constexpr uint32_t kPasses = 2;
static_assert(kClusterTriangles == 128 && sizeof(LatticeBox) == 24);  // the shaders hard-code these values

template <typename Element>
void upload(const GlBuffer& buffer, const std::vector<Element>& elements) {
  glNamedBufferData(buffer.get(), static_cast<GLsizeiptr>(elements.size() * sizeof(Element)), elements.data(),
                    GL_STREAM_DRAW);
}

void makeRoom(const GlBuffer& buffer, size_t bytes) {
  glNamedBufferData(buffer.get(), static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_COPY);
}

void bind(Storage binding, const GlBuffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.get());
}

}  // namespace

GpuCulling::GpuCulling(uint64_t most_readable_bytes)
    : find_program_(linkComputeProgram(kFindShader)),
      list_program_(linkComputeProgram(kListShader)),
      cameras_buffer_(GlBuffer::create()),
      chunks_buffer_(GlBuffer::create()),
      lists_buffer_(GlBuffer::create()),
      found_(GlBuffer::create()),
      commands_(GlBuffer::create()),
      counts_(GlBuffer::create()),
      triangles_(GlBuffer::create()) {
  static_assert(kTriangles < 8);  // OpenGL guarantees eight bindings
  GLint64 most_bytes = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most_bytes);
  most_readable_bytes_ = std::min(most_readable_bytes, static_cast<uint64_t>(most_bytes));
  constexpr GLbitfield kKept = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  constexpr std::array<uint32_t, kPicturesKept> kNothing{};
  glNamedBufferStorage(triangles_.get(), sizeof(kNothing), kNothing.data(), kKept | GL_CLIENT_STORAGE_BIT);
  mapped_triangles_ =
      static_cast<const uint32_t*>(glMapNamedBufferRange(triangles_.get(), 0, sizeof(kNothing), kKept));
}

GpuCulling::~GpuCulling() {
  for (const GLsync fence : count_fences_) glDeleteSync(fence);
  if (mapped_triangles_ != nullptr) glUnmapNamedBuffer(triangles_.get());
}

bool GpuCulling::isPossible() {
  return epoxy_gl_version() >= 46 || epoxy_has_gl_extension("GL_ARB_indirect_parameters");
}

void GpuCulling::begin() {
  picture_ = (picture_ + 1) % kPicturesKept;
  listed_.clear();
  cameras_.clear();
}

uint32_t GpuCulling::add(std::span<const SeenPart> parts, const GpuPages& pages, double lattice_step,
                         const core::View& view, const std::optional<core::View>& last_view) {
  const auto instance = static_cast<uint32_t>(cameras_.size());
  for (const SeenPart& part : parts) listed_.push_back({part, &pages, instance});
  const auto cameraOf = [lattice_step](const core::View& seen, bool hides) {
    const SplitEye eye = splitEye(seen.eye_model, lattice_step);
    const glm::mat3 axes = glm::transpose(viewRotation(seen));
    const Projection projection = reversedProjection(seen, lattice_step);
    const double near_steps = projection.near_model / lattice_step;
    return Camera{glm::ivec4(eye.high, hides), glm::vec4(eye.low, 0), glm::vec4(axes[0], projection.scale.x),
                  glm::vec4(axes[1], projection.scale.y), glm::vec4(axes[2], static_cast<float>(near_steps))};
  };
  const bool hides = last_view.has_value() && depths_.widthPx() > 0;
  cameras_.push_back({cameraOf(view, true), cameraOf(hides ? *last_view : view, hides)});
  return instance;
}

/// Builds chunks, groups and lists. Sorts parts by page, so that each page is bound once, then by instance.
void GpuCulling::layOut() {
  chunks_.clear();
  groups_.clear();
  lists_.clear();
  draws_.clear();
  most_commands_ = 0;
  const auto pageOf = [](const Listed& listed) { return listed.pages->buffer(listed.part.item->page); };
  std::ranges::stable_sort(listed_, {}, [&](const Listed& listed) {
    return std::tuple(pageOf(listed), listed.instance, listed.part.fades);
  });
  for (const Listed& listed : listed_) {
    const auto chunks = static_cast<uint32_t>(chunks_.size());
    const bool is_new_page = groups_.empty() || groups_.back().page != pageOf(listed);
    const auto added = static_cast<uint32_t>(listed.part.item->clusters->boxes.size() / kChunkClusters + 1);
    if (is_new_page || groups_.back().chunks + added > kMostWorkGroups) {
      const bool is_readable = listed.pages->pageBytes(listed.part.item->page) <= most_readable_bytes_;
      groups_.push_back({pageOf(listed), is_readable, chunks, 0});
    }
    if (is_new_page || draws_.back().instance != listed.instance ||
        draws_.back().fades != listed.part.fades) {
      const auto list = static_cast<uint32_t>(lists_.size());
      draws_.push_back({listed.instance, listed.part.fades, listed.part.item->page, most_commands_, 0, list});
      lists_.push_back({chunks, 0, most_commands_});
    }
    addChunks(listed.part, listed.instance);
  }
  std::ranges::stable_sort(draws_, {}, [](const Draw& draw) { return std::pair(draw.instance, draw.fades); });
}

void GpuCulling::addChunks(const SeenPart& part, uint32_t instance) {
  constexpr uint32_t kBoxWords = sizeof(LatticeBox) / sizeof(uint32_t);
  constexpr uint32_t kClusterIndices = 3 * kClusterTriangles;
  const DrawItem& item = *part.item;
  const auto clusters = static_cast<uint32_t>(item.clusters->boxes.size());
  for (uint32_t first = 0; first < clusters; first += kChunkClusters) {
    const uint32_t count = std::min(kChunkClusters, clusters - first);
    const uint32_t indices_before = first * kClusterIndices;
    chunks_.push_back({item.first_box_word + first * kBoxWords, count, item.first_index + indices_before,
                       std::min(kChunkClusters * kClusterIndices, item.index_count - indices_before),
                       static_cast<int32_t>(item.base_vertex), part.state, instance});
    ++groups_.back().chunks;
    ++lists_.back().chunks;
    const uint32_t most_runs = (count + 1) / 2;  // at least one cluster lies between two runs
    draws_.back().most_commands += most_runs;
    most_commands_ += most_runs;
  }
}

void GpuCulling::findUnhidden() {
  layOut();
  upload(cameras_buffer_, cameras_);
  upload(chunks_buffer_, chunks_);
  upload(lists_buffer_, lists_);
  makeRoom(found_, kPasses * chunks_.size() * sizeof(uint64_t));
  makeRoom(commands_, kPasses * most_commands_ * sizeof(DrawCommand));
  makeRoom(counts_, kPasses * lists_.size() * sizeof(uint32_t));
  glClearNamedBufferSubData(triangles_.get(), GL_R32UI, picture_ * sizeof(uint32_t), sizeof(uint32_t),
                            GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
  pass_ = 0;
  find(true);
}

void GpuCulling::findAppeared(const Framebuffer& drawn) {
  depths_.build(drawn);
  pass_ = 1;
  find(false);
  glDeleteSync(std::exchange(count_fences_[picture_], glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)));
}

/// Runs a pass. @param by_last_picture  true if depths_ has the depth of the last picture, false if it has
/// the depth of this picture.
void GpuCulling::find(bool by_last_picture) {
  if (lists_.empty()) return;
  bind(kChunks, chunks_buffer_);
  bind(kFound, found_);
  bind(kCameras, cameras_buffer_);
  if (depths_.widthPx() > 0) glBindTextureUnit(kPyramidUnit, depths_.texture());
  glUseProgram(find_program_.get());
  glUniform1ui(kFindPass, by_last_picture ? 0 : 1);
  glUniform1ui(kFindChunks, static_cast<GLuint>(chunks_.size()));
  glUniform2f(kDepthSizePx, static_cast<float>(depths_.widthPx()), static_cast<float>(depths_.heightPx()));
  for (const Group& group : groups_) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kPage, group.is_readable ? group.page : chunks_buffer_.get());
    glUniform1ui(kFirstChunk, group.first_chunk);
    glUniform1ui(kHasBoxes, group.is_readable);
    glDispatchCompute(group.chunks, 1, 1);
  }
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  bind(kLists, lists_buffer_);
  bind(kCommands, commands_);
  bind(kCounts, counts_);
  bind(kTriangles, triangles_);
  glUseProgram(list_program_.get());
  glUniform1ui(kListPass, pass_);
  glUniform1ui(kListChunks, static_cast<GLuint>(chunks_.size()));
  glUniform1ui(kListCommands, most_commands_);
  glUniform1ui(kListLists, static_cast<GLuint>(lists_.size()));
  glUniform1ui(kTrianglesPlace, picture_);
  const auto lists = static_cast<uint32_t>(lists_.size());
  for (uint32_t first = 0; first < lists; first += kMostWorkGroups) {
    glUniform1ui(kFirstList, first);
    glDispatchCompute(std::min(kMostWorkGroups, lists - first), 1, 1);
  }
  glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT |
                  GL_BUFFER_UPDATE_BARRIER_BIT);
}

std::span<const GpuCulling::Draw> GpuCulling::draws(uint32_t instance) const {
  return {std::ranges::lower_bound(draws_, instance, {}, &Draw::instance),
          std::ranges::upper_bound(draws_, instance, {}, &Draw::instance)};
}

uint64_t GpuCulling::trianglesLately() {
  const uint32_t oldest = (picture_ + 1) % kPicturesKept;
  if (count_fences_[oldest] == nullptr || mapped_triangles_ == nullptr) return triangles_lately_;
  if (glClientWaitSync(count_fences_[oldest], 0, 0) != GL_TIMEOUT_EXPIRED)
    triangles_lately_ = mapped_triangles_[oldest];
  return triangles_lately_;
}

}  // namespace lode::render
