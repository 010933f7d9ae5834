#include "client/app/window/output/picture_file.h"

#include <charconv>
#include <cstdio>
#include <ctime>
#include <system_error>

#include "client/app/cli/target.h"
#include "common/error.h"
#include "common/io/output_target.h"
#include "common/printable.h"

namespace lode::app {

namespace fs = std::filesystem;

void checkPictureFile(std::string_view target, const fs::path& picture) {
  std::error_code failed;  // ignored here; the error is reported when the file is written
  const fs::file_status status = fs::status(picture, failed);
  if (fs::is_fifo(status) || fs::is_character_file(status)) return;
  if (isStandardOutput(picture)) return;
  if (fileEnding(picture) != ".png")
    throw Error(ErrorCode::kUsage, picture.string() + ": pictures are PNG files; give it the ending .png");
  if (fs::is_directory(status))
    throw Error(ErrorCode::kUsage, picture.string() + ": is a directory; name a file in it");
  refuseToReplace(target, picture);
}

std::string timedName(const std::string& ending) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char name[64];
  std::strftime(name, sizeof name, "lodestream-%Y%m%d-%H%M%S.", &local);
  return name + ending;
}

std::string frameName(size_t frame) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%06zu.png", frame);
  return name;
}

void makeFilmFolder(const fs::path& folder) {
  followLinks(folder);  // followLinks() throws for a link that another user owns
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed)
    throw Error(ErrorCode::kIo, folder.string() + " cannot be made: " + failed.message() +
                                    "; choose another folder for --frames");
}

void refuseOtherFilm(const fs::path& folder, size_t frames) {
  constexpr std::string_view kPrefix = "frame_";
  std::error_code failed;
  fs::directory_iterator entry(folder, failed);
  for (; !failed && entry != fs::directory_iterator(); entry.increment(failed)) {
    const std::string name = entry->path().filename();
    if (!name.starts_with(kPrefix)) continue;
    size_t frame = 0;
    std::from_chars(name.data() + kPrefix.size(), name.data() + name.size(), frame);
    if (name == frameName(frame) && frame >= frames)
      throw Error(ErrorCode::kUsage,
                  entry->path().string() + " belongs to another film: this film has only " +
                      counted(frames, "frame") + "; remove it, or choose another folder for --frames");
  }
  if (failed)
    throw Error(ErrorCode::kIo, folder.string() + " cannot be listed: " + failed.message() +
                                    "; choose another folder for --frames");
}

}  // namespace lode::app
