#include "client/app/cli/built_store.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "client/app/cli/build_step.h"
#include "client/app/cli/child_process.h"
#include "client/app/cli/store_cache.h"
#include "common/codec/blob.h"
#include "common/error.h"
#include "common/io/own_folder.h"
#include "common/io/texture_finder.h"
#include "common/printable.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::chrono::hours kLongestSilence{24 * 7};  // longest time between two lines of a build's output
constexpr std::chrono::milliseconds kLockPoll{100};
constexpr size_t kKeyDigits = 16;
constexpr std::string_view kPreviewFolder = "preview";

std::string hashOf(const std::string& text) {
  return toHex(digestOf(std::as_bytes(std::span(text)))).substr(0, kKeyDigits);
}

std::string inWords(const timespec& time) {
  return " " + std::to_string(time.tv_sec) + "." + std::to_string(time.tv_nsec);
}

/// Returns a text that changes whenever the file changes. The text includes the file's change time, which
/// only the kernel sets, because programs that unpack or copy files may set any modification time.
std::string versionOf(const struct stat& status) {
  return std::to_string(status.st_size) + inWords(status.st_mtim) + inWords(status.st_ctim);
}

/// Returns the version of a file, or an empty text if the file is missing.
std::string versionOf(const fs::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? versionOf(status) : std::string();
}

/// Returns the time that the kernel would record for a file that changes now.
timespec fileTime() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME_COARSE, &now);
  return now;
}

/// Returns the version of a file if the file has not changed since `time`. Returns a text that differs from
/// every version if the file has changed, and an empty text if the file is missing.
std::string versionSince(const fs::path& path, timespec time) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  const timespec& changed = status.st_ctim;
  return std::tie(changed.tv_sec, changed.tv_nsec) < std::tie(time.tv_sec, time.tv_nsec) ? versionOf(status)
                                                                                         : "changed";
}

/// An exclusive lock on the cache folder of a source file. The lock lasts until this object is destroyed and
/// every child process that inherited the lock has ended. The constructor creates missing folders, which only
/// this user can access.
class FolderLock {
 public:
  /// Waits until the lock is free. @throws Error kIo, or kTimeout if `stop` is requested.
  FolderLock(const fs::path& folder, const fs::path& ply, bool announce, const std::stop_token& stop)
      : path_(folder / kStoreBuildLock) {
    for (bool told = !announce; !take(); std::this_thread::sleep_for(kLockPoll)) {
      if (stop.stop_requested())
        throw Error(ErrorCode::kTimeout, ply.string() + ": stopped while another program builds it");
      if (!std::exchange(told, true))
        std::fprintf(stderr, "lodestream: another program builds %s: waiting for it\n", ply.c_str());
    }
  }

  int descriptor() const noexcept { return lock_->descriptor(); }

  /// Removes the lock file, and then the folder if it is empty.
  void removeEmptyFolder() const {
    std::error_code ignored;
    fs::remove(path_, ignored);
    fs::remove(path_.parent_path(), ignored);
  }

 private:
  /// Tries to lock the folder. @return false if another program holds the lock or has just removed the
  /// folder.
  bool take() {
    const fs::path of_source = path_.parent_path(), stores = of_source.parent_path();
    makeOwnFolders(stores.parent_path(), kCacheFolderUse);
    makeOwnFolder(stores, kCacheFolderUse);
    makeOwnFolder(of_source, kCacheFolderUse);
    lock_ = FileLock::tryTake(path_, FileLock::Kind::kExclusive, true);
    if (lock_) return true;
    const bool has_just_gone = errno == ENOENT;  // another program removed the folder
    if (errno != 0 && !has_just_gone)
      throw Error(ErrorCode::kIo, path_.string() + " cannot be locked: " + std::strerror(errno) + "; " +
                                      kCacheFolderUse.remedy);
    return false;
  }

  fs::path path_;
  std::optional<FileLock> lock_;
};

/// Contents of the file kBuildRecord beside a store: the warnings of the build, and the images that the build
/// looked for.
struct BuildRecord {
  struct Image {
    std::string name;     ///< name in the PLY file
    fs::path path;        ///< path of the image; empty if no file was found
    std::string version;  ///< version of the file at that path
  };
  std::vector<std::string> warnings;
  fs::path textures_folder;  ///< folder that the build searched first for images
  std::vector<Image> images;

  /// Returns true if a build now would find the same images. If an image is missing, compares textures_folder
  /// too, because the build's warnings name this folder.
  bool isCurrent(const PlyFile& ply) const {
    TextureFinder finder(ply.path, ply.textures_folder);
    return std::ranges::all_of(images, [&](const Image& image) {
      return finder.find(image.name).path == image.path && versionOf(image.path) == image.version &&
             (!image.path.empty() || ply.textures_folder == textures_folder);
    });
  }
};

std::vector<std::string> textsIn(const Json& json, const char* key) {
  std::vector<std::string> texts;
  if (!json.is_object() || !json.contains(key) || !json[key].is_array()) return texts;
  for (const Json& text : json[key])
    if (text.is_string()) texts.push_back(text.get<std::string>());
  return texts;
}

std::optional<BuildRecord> readRecord(const fs::path& folder) {
  std::ifstream file(folder / kBuildRecord);
  const Json json = Json::parse(file, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  BuildRecord record;
  record.warnings = textsIn(json, "warnings");
  const std::vector<std::string> names = textsIn(json, "names"), paths = textsIn(json, "images"),
                                 versions = textsIn(json, "versions");
  if (names.size() != paths.size() || names.size() != versions.size()) return std::nullopt;
  for (size_t i = 0; i < names.size(); ++i) record.images.push_back({names[i], paths[i], versions[i]});
  if (json.contains("textures_folder") && json["textures_folder"].is_string())
    record.textures_folder = json["textures_folder"].get<std::string>();
  return record;
}

/// Writes the record. Ignores a failure, because the next use then just builds the store again.
void writeRecord(const fs::path& folder, const BuildRecord& record) {
  Json json{{"warnings", record.warnings},
            {"textures_folder", record.textures_folder.string()},
            {"names", Json::array()},
            {"images", Json::array()},
            {"versions", Json::array()}};
  for (const BuildRecord::Image& image : record.images) {
    json["names"].push_back(image.name);
    json["images"].push_back(image.path.string());
    json["versions"].push_back(image.version);
  }
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  writeOwnFile(folder / kBuildRecord, std::as_bytes(std::span(text)));
}

/// Removes the stores of all other versions from a source's folder.
void removeOthers(const fs::path& folder, const fs::path& keep) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path() != keep && entry.path().filename() != kStoreBuildLock)
      fs::remove_all(entry.path(), ignored);
}

void tell(const std::function<void(const BuildStep&)>& watch, const Json& line) {
  if (!line.contains("doing") || !line["doing"].is_string() || !line.contains("build_fraction") ||
      !line["build_fraction"].is_number())
    return;
  BuildStep step;
  step.doing = line["doing"].get<std::string>();
  step.fraction = std::clamp(line["build_fraction"].get<double>(), 0.0, 1.0);
  const auto number = [&line](const char* key) -> std::optional<double> {
    const auto found = line.find(key);
    return found != line.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
  };
  step.seconds_left = number("seconds_left");
  step.done = number("done").value_or(0);
  step.total = number("total").value_or(0);
  step.per_s = number("per_second").value_or(0);
  if (line.contains("unit") && line["unit"].is_string()) step.unit = line["unit"].get<std::string>();
  watch(step);
}

/// Returns a function that prints a line every five seconds on stderr.
std::function<void(const BuildStep&)> watchInLines(const fs::path& ply) {
  using Clock = std::chrono::steady_clock;
  return [ply = ply.string(), log = BuildLog(Clock::now())](const BuildStep& step) mutable {
    if (const auto line = log.add(step, Clock::now()))
      printOnOneLine("lodestream", "building " + ply + ": " + *line);
  };
}

/// Builds a store in a child process.
/// @param lock  lock that the child inherits, because the child may outlive this program for a while.
/// @return the last line of JSON that the build printed. @throws Error if the build fails.
Json build(const PlyFile& source, const fs::path& store, const FolderLock& lock, bool shows_progress,
           const std::stop_token& stop, const BuildWatch& watch) {
  std::vector<std::string> arguments{"build", source.path.string(), source.preview_only ? "--preview" : "-o",
                                     store.string(), "--json"};
  if (!source.preview_only) arguments.insert(arguments.end(), {"--resume", "--restart-if-changed"});
  if (!source.textures_folder.empty())
    arguments.insert(arguments.end(), {"--textures", source.textures_folder.string()});
  if (!shows_progress) arguments.emplace_back(watch.on_step ? "--json-progress" : "--quiet");
  const fs::path preview = previewBeside(store);
  if (watch.on_preview) {
    makeOwnFolder(preview.parent_path(), kCacheFolderUse);
    arguments.insert(arguments.end(), {"--preview", preview.string()});
  }
  ChildProcess builder(siblingServer(), arguments,
                       shows_progress ? ChildProcess::Messages::kPassOn : ChildProcess::Messages::kKeep,
                       {.input = {},
                        .inherited = lock.descriptor(),
                        .is_private = true,
                        .yields = static_cast<bool>(watch.on_preview)});
  Json result;
  {
    const std::stop_callback end_build(stop, [&builder] { builder.terminate(); });
    // A resumed build may write no preview, because the interrupted build has written one.
    bool has_preview = watch.on_preview && fs::exists(preview);
    if (has_preview) watch.on_preview(preview);
    for (std::string line; !(line = builder.readLine(kLongestSilence)).empty();) {
      Json json = Json::parse(line, nullptr, false);
      if (!json.is_object()) continue;
      if (watch.on_step) tell(watch.on_step, json);
      if (watch.on_preview && !has_preview && json.value("stage", "") == "preview") {
        has_preview = true;
        watch.on_preview(preview);
      }
      result = std::move(json);
    }
  }
  if (const int status = builder.wait(); status != 0)
    throw Error(ErrorCode::kInput, saidBy(builder, "building " + source.path.string() +
                                                       " failed with exit status " + std::to_string(status)));
  return result;
}

void warn(const BuildRecord& record) {
  for (const std::string& warning : record.warnings)
    std::fprintf(stderr, "lodestream: warning: %s\n", warning.c_str());
}

}  // namespace

std::shared_ptr<const CopiedInput> copyStandardInput() {
  const fs::path stores = storesFolder();
  makeOwnFolders(stores.parent_path(), kCacheFolderUse);
  makeOwnFolder(stores, kCacheFolderUse);
  return std::make_shared<const CopiedInput>(STDIN_FILENO, stores, copyBytesIn(stores));
}

bool isCopyOfInput(const fs::path& path) {
  const fs::path stores = fs::absolute(storesFolder()).lexically_normal();
  return path.parent_path().parent_path() == stores;
}

fs::path previewBeside(const fs::path& store) {
  return store.parent_path() / kPreviewFolder / store.filename();
}

BuiltStore builtStore(const PlyFile& ply, bool announce, const std::stop_token& stop, const BuildWatch& watch,
                      std::optional<uint64_t> max_bytes) {
  PlyFile source{fs::absolute(ply.path).lexically_normal(), {}, ply.preview_only};
  if (!ply.textures_folder.empty())
    source.textures_folder = fs::absolute(ply.textures_folder).lexically_normal();
  const fs::path stores = storesFolder();
  const fs::path of_source =
      isCopyOfInput(source.path) ? source.path.parent_path() : stores / hashOf(source.path.string());
  const fs::path folder = of_source / hashOf(versionOf(source.path) + " " + versionOf(siblingServer()) +
                                             (ply.preview_only ? " preview" : ""));
  const fs::path store = folder / (source.path.stem().string() + ".lode");
  const FolderLock lock(of_source, ply.path, announce, stop);
  if (const auto record = readRecord(folder); record && record->isCurrent(source) && fs::exists(store)) {
    warn(*record);
    return {store, useStore(store), record->warnings, ply.preview_only};
  }
  std::error_code ignored;
  makeOwnFolder(folder, kCacheFolderUse);
  const bool shows_progress = announce && !watch.on_step && isatty(STDERR_FILENO) == 1;
  BuildWatch told = watch;
  if (announce && !watch.on_step && !shows_progress) told.on_step = watchInLines(ply.path);
  BuildRecord record;
  try {
    const timespec start = fileTime();
    const Json built = build(source, store, lock, shows_progress, stop, told);
    record.warnings = textsIn(built, "warnings");
    record.textures_folder = source.textures_folder;
    TextureFinder finder(source.path, source.textures_folder);
    for (const std::string& name : textsIn(built, "texture_files")) {
      const fs::path image = finder.find(name).path;
      record.images.push_back({name, image, versionSince(image, start)});
    }
  } catch (...) {
    // If the next use can resume the build, the folder contains its work, and fs::remove() keeps a folder
    // that is not empty.
    if (!stop.stop_requested()) fs::remove_all(previewBeside(store).parent_path(), ignored);
    if (ply.preview_only) fs::remove_all(folder, ignored);
    fs::remove(folder, ignored);
    lock.removeEmptyFolder();
    throw;
  }
  const fs::path preview_folder = previewBeside(store).parent_path();
  fs::remove(preview_folder, ignored);                             // unless it has a preview
  if (!watch.on_preview) fs::remove_all(preview_folder, ignored);  // else the caller removes it
  writeRecord(folder, record);
  if (!ply.preview_only) removeOthers(of_source, folder);
  FileLock in_use = useStore(store);
  trimStores(stores, max_bytes.value_or(storeCacheBytes(stores)));
  if (!shows_progress) warn(record);  // a build that shows progress has printed the warnings itself
  return {store, std::move(in_use), std::move(record.warnings), ply.preview_only};
}

}  // namespace lode::app
