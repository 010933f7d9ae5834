#include "client/app/window/output/film_folder.h"

#include <charconv>
#include <cstdio>
#include <string_view>

#include "common/error.h"
#include "common/printable.h"

namespace lode::app {

namespace fs = std::filesystem;

std::string frameName(size_t frame) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%06zu.png", frame);
  return name;
}

void makeFilmFolder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed)
    throw Error(ErrorCode::kIo, folder.string() + " cannot be made: " + failed.message() +
                                    "; choose another folder for --frames");
}

void refuseOtherFilm(const fs::path& folder, size_t frames) {
  constexpr std::string_view kBefore = "frame_";
  std::error_code failed;
  fs::directory_iterator entry(folder, failed);
  for (; !failed && entry != fs::directory_iterator(); entry.increment(failed)) {
    const std::string name = entry->path().filename();
    if (!name.starts_with(kBefore)) continue;
    size_t frame = 0;
    std::from_chars(name.data() + kBefore.size(), name.data() + name.size(), frame);
    if (name == frameName(frame) && frame >= frames)
      throw Error(ErrorCode::kUsage, entry->path().string() + " is of another film, behind the " +
                                         counted(frames, "frame") +
                                         " of this one: remove it, or choose another folder for --frames");
  }
  if (failed)
    throw Error(ErrorCode::kIo, folder.string() + " cannot be listed: " + failed.message() +
                                    "; choose another folder for --frames");
}

}  // namespace lode::app
