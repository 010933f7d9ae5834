#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/ingest/disk/spool.h"
#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/pipeline/scan_stage.h"
#include "server/ingest/textures/texture_images.h"
#include "server/ingest/textures/textures.h"

namespace lode::ingest {

/// Looks for the images that an input names. To leave out one that is too large for the memory would make the
/// store follow from --memory. @throws Error kLimit for such a one.
std::vector<TextureImage> findImages(BuildSession& session, std::span<const std::string> names);

/// Makes the images into tiles.
class TextureStage final : public Stage {
 public:
  TextureStage(BuildSession& session, ScanStage& scan);

  bool isNeeded() const override { return !scan_.textureFiles().empty(); }
  Work run() override;
  void save(RecordWriter& record) const override;
  void load(RecordReader& record, bool is_used_up) override;

  const StagedTextures& textures() const noexcept { return textures_; }
  /// Null if there are none.
  const Spool* tiles() const noexcept { return tiles_ ? &*tiles_ : nullptr; }

 private:
  BuildSession& session_;
  ScanStage& scan_;
  StagedTextures textures_;
  std::optional<Spool> tiles_;
};

}  // namespace lode::ingest
