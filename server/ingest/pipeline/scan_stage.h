#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/soup/packed_input.h"
#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// Reads the file once: packed vertices and faces, and what all later stages know of the model.
class ScanStage final : public Stage {
 public:
  explicit ScanStage(BuildSession& session);

  Work run() override;
  void save(RecordWriter& record) const override;
  void load(RecordReader& record, bool is_used_up) override;

  /// Those that the header names, if there are texture coordinates for them.
  const std::vector<std::string>& textureFiles() const noexcept { return texture_files_; }
  /// What was found of them; nothing after load().
  std::vector<TextureImage> takeImages() { return std::move(images_); }
  std::unique_ptr<PackedInput> takeInput() { return std::move(input_); }

 private:
  void noteFacts(const PackedInput& input, uint64_t dropped_triangles);

  BuildSession& session_;
  std::vector<std::string> texture_files_;
  std::vector<TextureImage> images_;
  std::unique_ptr<PackedInput> input_;
};

}  // namespace lode::ingest
