#include "client/render/residency/texture_residency.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <span>
#include <vector>

namespace lode::render {
namespace {

constexpr uint32_t kFirstLayers = 4;  // initial number of layers of the array; the number doubles when the
                                      // array is full

uint64_t texelBytes(const TileImage& image) {
  uint64_t texels = image.texels.size();
  for (const TileImage& coarser : image.coarser) texels += coarser.texels.size();
  return texels * sizeof(glm::u8vec4);
}

uint32_t layersOf(uint64_t budget_bytes) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &limit);
  const uint64_t layers = std::max<uint64_t>(budget_bytes / kTileLayerBytes, 1);
  return static_cast<uint32_t>(std::min<uint64_t>(layers, static_cast<uint64_t>(limit)));
}

}  // namespace

TextureResidency::TextureResidency(uint64_t budget_bytes, uint32_t staging_bytes)
    : placement_(layersOf(budget_bytes)),
      most_layers_(layersOf(budget_bytes)),
      staging_bytes_(staging_bytes) {}

void TextureResidency::setBudget(uint64_t bytes) {
  const uint32_t layers = layersOf(bytes);
  if (layers == most_layers_) return;
  most_layers_ = layers;
  placement_.allow(layers);
  if (layers < array_layers_) release();
}

void TextureResidency::release() {
  array_ = {};
  array_layers_ = 0;
  placement_.clear();
}

void TextureResidency::show(const std::shared_ptr<const core::Cut>& newest,
                            const std::shared_ptr<const core::Cut>& drawn) {
  placement_.show(newest, drawn);
  writeTable();
  if (placement_.set() && !staging_) staging_.emplace(staging_bytes_);
}

/// Copies the changed words of the table to the GPU.
void TextureResidency::writeTable() {
  const std::vector<uint32_t>& table = placement_.table();
  const std::vector<size_t> changed = placement_.takeChangedWords();
  constexpr size_t kWordBytes = sizeof(uint32_t);
  if (table_serial_ != placement_.tableSerial()) {
    table_serial_ = placement_.tableSerial();
    if (!placement_.set()) return;
    constexpr uint32_t kNoTextures = 0;
    table_ = GlBuffer::create();
    glNamedBufferStorage(table_.get(),
                         static_cast<GLsizeiptr>(std::max<size_t>(table.size(), 1) * kWordBytes),
                         table.empty() ? &kNoTextures : table.data(), GL_DYNAMIC_STORAGE_BIT);
    return;
  }
  for (const size_t index : changed)
    glNamedBufferSubData(table_.get(), static_cast<GLintptr>(index * kWordBytes), kWordBytes, &table[index]);
}

uint64_t TextureResidency::uploadInRenderThread(const UploadBudget& budget) {
  if (placement_.next() == nullptr) return 0;
  const auto start = std::chrono::steady_clock::now();
  const auto spent_ms = [start] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  };
  uint64_t uploaded_bytes = 0;
  do {
    if (!staging_->open(budget.wait)) break;
    uint32_t left_bytes = staging_bytes_;
    while (const core::ResidentTile* const tile = placement_.next()) {
      const auto bytes = static_cast<uint32_t>(texelBytes(*tile->image));
      const bool over =
          uploaded_bytes != 0 && (uploaded_bytes + bytes > budget.bytes || spent_ms() > budget.ms);
      if (bytes > left_bytes || (over && !budget.wait)) break;
      if (!uploadNext()) continue;
      left_bytes -= bytes;
      uploaded_bytes += bytes;
    }
    staging_->close();
  } while (budget.wait && placement_.next() != nullptr);
  writeTable();
  return uploaded_bytes;
}

/// Uploads the image of the next tile. @return true if the image was uploaded, false if it was already
/// resident or does not fit.
bool TextureResidency::uploadNext() {
  const std::shared_ptr<const TileImage> image = placement_.next()->image;
  const std::span<const TileCell> cells = placement_.place();
  if (cells.empty()) return false;
  if (placement_.layers() > array_layers_ && !growTo(placement_.layers())) {
    placement_.repack(most_layers_);
    return false;
  }
  copy(*image, cells[0]);
  for (size_t i = 1; i < cells.size(); ++i) copy(image->coarser[i - 1], cells[i]);
  return true;
}

void TextureResidency::copy(const TileImage& image, const TileCell& cell) {
  const std::span<const std::byte> texels = std::as_bytes(std::span(image.texels));
  const std::span<std::byte> room = staging_->take(static_cast<uint32_t>(texels.size()));
  std::memcpy(room.data(), texels.data(), texels.size());
  staging_->copyTo(array_.get(), static_cast<GLint>(cell.layer), glm::ivec2(cell.corner),
                   glm::ivec2(image.size));
}

/// Grows the array. While the old array is copied, both arrays take memory. An array that would exceed half
/// the limit therefore gets the whole limit at once, so that only smaller arrays are ever copied.
/// @return false if the driver is out of memory; the array then stays as it is.
bool TextureResidency::growTo(uint32_t layers) {
  uint32_t wanted = std::min(most_layers_, std::max({layers, 2 * array_layers_, kFirstLayers}));
  if (2 * wanted > most_layers_) wanted = most_layers_;
  while (glGetError() != GL_NO_ERROR) {
  }
  GlTextureArray array = GlTextureArray::create();
  glTextureStorage3D(array.get(), 1, GL_SRGB8_ALPHA8, GLsizei{kTilePx}, GLsizei{kTilePx},
                     static_cast<GLsizei>(wanted));
  if (glGetError() != GL_NO_ERROR) {
    most_layers_ = array_layers_;
    return false;
  }
  glTextureParameteri(array.get(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(array.get(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(array.get(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(array.get(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  if (array_layers_ != 0) {
    glCopyImageSubData(array_.get(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, array.get(), GL_TEXTURE_2D_ARRAY, 0, 0,
                       0, 0, GLsizei{kTilePx}, GLsizei{kTilePx}, static_cast<GLsizei>(array_layers_));
  }
  array_ = std::move(array);
  array_layers_ = wanted;
  return true;
}

void TextureResidency::bind() const {
  glBindTextureUnit(0, array_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, table_.get());
}

}  // namespace lode::render
