#include "server/ingest/pipeline/scan_stage.h"

#include "server/ingest/pipeline/texture_stage.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/ingest/soup/scan.h"
#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

ScanStage::ScanStage(BuildSession& session)
    : Stage({.name = "scan",
             .entry = BuildEntry::kScanned,
             .used_up_by = BuildEntry::kDereferenced,
             .files = {PackedInput::kVertexFile, PackedInput::kFaceFile}}),
      session_(session) {}

Stage::Work ScanStage::run() {
  const BuildOptions& options = session_.options();
  {
    // So early that what is wrong with the images as a whole costs no time.
    const PlyReader reader(options.input, {.skip_bad = options.skip_bad});
    if (reader.attributes().has(AttributeSet::kTexture))
      images_ = findImages(session_, reader.header().texture_files);
  }
  std::vector<std::string> warnings;
  ScannedModel scanned = scan(options, session_.files(), session_.progress(), warnings);
  session_.warn(warnings);
  noteFacts(scanned.input, scanned.counts.dropped_triangles);
  if (scanned.input.attributes().has(AttributeSet::kTexture)) {
    texture_files_ = std::move(scanned.texture_files);
    if (texture_files_.empty()) session_.warn(options.input.string() + ": " + kNoTextureFile);
  } else if (!scanned.texture_files.empty()) {
    session_.warn(options.input.string() +
                  ": it names texture files, but has no texture coordinates; they are left out");
  }
  input_ = std::make_unique<PackedInput>(std::move(scanned.input));
  return {input_->vertexCount() + input_->faceCount(), input_->temporaryBytes()};
}

void ScanStage::noteFacts(const PackedInput& input, uint64_t dropped_triangles) {
  BuildFacts& facts = session_.facts();
  facts.choice = chooseLattice(input, session_.options().input);
  facts.soup_attributes = input.attributes();
  facts.uv_grid = input.uvGrid();
  facts.dropped_triangles = dropped_triangles;
}

void ScanStage::save(RecordWriter& record) const {
  record.putTexts(texture_files_);
  input_->save(record);
}

void ScanStage::load(RecordReader& record, bool is_used_up) {
  texture_files_ = record.getTexts();
  if (!is_used_up) input_ = std::make_unique<PackedInput>(PackedInput::load(session_.files(), record));
}

}  // namespace lode::ingest
