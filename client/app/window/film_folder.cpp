#include "client/app/window/film_folder.h"

#include <charconv>
#include <cstdio>
#include <string_view>

#include "common/error.h"

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
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(kBefore)) continue;
    size_t frame = 0;
    std::from_chars(name.data() + kBefore.size(), name.data() + name.size(), frame);
    if (name == frameName(frame) && frame >= frames)
      throw Error(ErrorCode::kUsage, entry.path().string() + " is of another film, behind the " +
                                         std::to_string(frames) +
                                         " frames of this one: remove it, or choose another folder for "
                                         "--frames");
  }
}

}  // namespace lode::app
