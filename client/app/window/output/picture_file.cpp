#include "client/app/window/output/picture_file.h"

#include <system_error>

#include "client/app/cli/target.h"
#include "common/error.h"
#include "common/io/file_ending.h"
#include "common/io/output_target.h"

namespace lode::app {

void checkPictureFile(std::string_view target, const std::filesystem::path& picture) {
  std::error_code failed;  // said by who writes
  const std::filesystem::file_status status = std::filesystem::status(picture, failed);
  if (std::filesystem::is_fifo(status) || std::filesystem::is_character_file(status)) return;
  if (isStandardOutput(picture)) return;
  if (fileEnding(picture) != ".png")
    throw Error(ErrorCode::kUsage, picture.string() + ": pictures are PNG files: give it the ending .png");
  if (std::filesystem::is_directory(status))
    throw Error(ErrorCode::kUsage, picture.string() + ": is a directory; name a file in it");
  refuseToReplace(target, picture);
}

}  // namespace lode::app
