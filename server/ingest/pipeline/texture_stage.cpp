#include "server/ingest/pipeline/texture_stage.h"

namespace lode::ingest {

std::vector<TextureImage> findImages(BuildSession& session, std::span<const std::string> names) {
  const BuildOptions& options = session.options();
  std::vector<TextureImage> images = surveyTextures(options.input, names, session.plan().image_bytes);
  for (const TextureImage& image : images)
    if (image.needs_memory)
      session.refuseForMemory(textureInWords(options.input, image.name) + " " + image.problem);
  return images;
}

TextureStage::TextureStage(BuildSession& session, ScanStage& scan)
    : Stage({.name = "textures",
             .entry = BuildEntry::kTextures,
             .used_up_by = BuildEntry::kPacked,
             .files = {StagedTextures::kFile}}),
      session_(session),
      scan_(scan) {}

Stage::Work TextureStage::run() {
  std::vector<TextureImage> images = scan_.takeImages();
  if (images.empty()) images = findImages(session_, scan_.textureFiles());
  tiles_.emplace(session_.files().lastingFile(StagedTextures::kFile));
  std::vector<std::string> warnings;
  textures_ = stageTextures(session_.options(), images, session_.facts().uv_grid, *tiles_,
                            session_.plan().image_bytes, session_.progress(), warnings);
  session_.warn(warnings);
  tiles_->sync();
  return {textures_.textures.size(), tiles_->size()};
}

void TextureStage::save(RecordWriter& record) const {
  record.put(tiles_->size());
  textures_.save(record);
}

void TextureStage::load(RecordReader& record, bool is_used_up) {
  const auto tile_bytes = record.get<uint64_t>();
  textures_ = StagedTextures::load(record);
  if (!is_used_up) tiles_.emplace(session_.files().lastingFile(StagedTextures::kFile), tile_bytes);
}

}  // namespace lode::ingest
