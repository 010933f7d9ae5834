#include "server/tiles/tile_export.h"

#include <atomic>
#include <exception>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/io/atomic_folder.h"
#include "common/start_thread.h"
#include "server/tiles/tile_writer.h"

namespace lode::tiles {
namespace {

/// Writes the JSON files, from the root down. @return one tile for each GLB file to write; tiles with equal
/// contents share a file.
std::vector<store::CutItem> writePages(const TileWriter& writer, AtomicFolder& folder,
                                       TileExportReport& report) {
  std::vector<store::CutItem> items;
  std::set<std::string> known;
  std::vector<NodeKey> todo{kRootKey};
  while (!todo.empty()) {
    const NodeKey owner = todo.back();
    todo.pop_back();
    const TilesetPage page = writer.page(owner);
    if (report.pages == 1) folder.makeFolder("p");
    folder.write(writer.pageName(owner), std::as_bytes(std::span(page.json)));
    ++report.pages;
    report.tiles += page.tiles;
    report.json_bytes += page.json.size();
    todo.insert(todo.end(), page.pages.begin(), page.pages.end());
    for (const store::CutItem item : page.contents) {
      if (known.insert(writer.glbName(item)).second) items.push_back(item);
    }
  }
  return items;
}

/// Calls a function for each number below a total, on several threads.
class SharedWork {
 public:
  SharedWork(size_t total, std::function<void(size_t number)> work) : total_(total), work_(std::move(work)) {}

  /// @throws the first exception of the work or of `progress`.
  void run(unsigned threads, const TileExportProgress& progress) {
    {
      const auto others = threads > 1 ? startThreads(threads - 1, "to write tiles", [this] { help(); })
                                      : std::vector<std::jthread>();
      try {
        do progress(done_, total_);
        while (doNext());
      } catch (...) {
        fail(std::current_exception());
      }
    }
    if (failure_) std::rethrow_exception(failure_);
    progress(done_, total_);
  }

 private:
  void help() noexcept {
    try {
      while (doNext()) continue;
    } catch (...) {
      fail(std::current_exception());
    }
  }

  /// @return false if no number is left, or if a thread has failed.
  bool doNext() {
    const size_t number = is_failed_ ? total_ : next_++;
    if (number >= total_) return false;
    work_(number);
    ++done_;
    return true;
  }

  void fail(std::exception_ptr failure) noexcept {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
    is_failed_ = true;
  }

  const size_t total_;
  const std::function<void(size_t number)> work_;
  std::atomic<size_t> next_ = 0;
  std::atomic<uint64_t> done_ = 0;
  std::atomic<bool> is_failed_ = false;
  std::mutex mutex_;
  std::exception_ptr failure_;  ///< first failure; guarded by mutex_ while threads run
};

/// Writes the GLB files, then the images that several GLB files share.
class ContentFiles {
 public:
  ContentFiles(const TileWriter& writer, AtomicFolder& folder, unsigned threads)
      : writer_(writer), folder_(folder), threads_(threads) {}

  void write(std::span<const store::CutItem> items, const TileExportProgress& progress) {
    if (!items.empty()) folder_.makeFolder("g");
    SharedWork(items.size(), [&](size_t number) { writeGlb(items[number]); }).run(threads_, progress);
    if (!images_.empty()) folder_.makeFolder("i");
    const std::vector<std::pair<std::string, SharedImage>> images(images_.begin(), images_.end());
    const auto write_image = [&](size_t number) { writeImage(images[number].first, images[number].second); };
    SharedWork(images.size(), write_image).run(threads_, [&](uint64_t, uint64_t) {
      progress(items.size(), items.size());
    });
  }

  uint64_t images() const noexcept { return images_.size(); }
  uint64_t glbBytes() const noexcept { return glb_bytes_; }
  uint64_t imageBytes() const noexcept { return image_bytes_; }

 private:
  void writeGlb(store::CutItem item) {
    const TileGlb glb = writer_.glb(item);
    folder_.write(writer_.glbName(item), glb.bytes);
    glb_bytes_ += glb.bytes.size();
    const std::lock_guard lock(mutex_);
    for (const SharedImage image : glb.images) images_.emplace(writer_.imageName(image), image);
  }

  void writeImage(const std::string& name, SharedImage image) {
    const std::vector<std::byte> file = writer_.image(image);
    folder_.write(name, file);
    image_bytes_ += file.size();
  }

  const TileWriter& writer_;
  AtomicFolder& folder_;
  const unsigned threads_;
  std::atomic<uint64_t> glb_bytes_ = 0, image_bytes_ = 0;
  std::mutex mutex_;
  /// Image files by name; guarded by mutex_ while GLB files are written. Equal textures share a name.
  std::map<std::string, SharedImage> images_;
};

}  // namespace

TileExportReport exportTiles(const store::Reader& reader, const TileExportOptions& options,
                             const TileExportProgress& progress) {
  AtomicFolder folder(options.folder);
  const TileWriter writer(reader, options.root_transform);
  TileExportReport report;
  const std::vector<store::CutItem> items = writePages(writer, folder, report);
  ContentFiles files(writer, folder, options.threads);
  files.write(items, progress);
  report.glbs = items.size();
  report.images = files.images();
  report.glb_bytes = files.glbBytes();
  report.image_bytes = files.imageBytes();
  folder.commit();
  return report;
}

}  // namespace lode::tiles
