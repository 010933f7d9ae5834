#include "server/tiles/tile_export.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "common/io/atomic_folder.h"
#include "common/start_thread.h"
#include "server/tiles/tile_writer.h"

namespace lode::tiles {
namespace {

/// Writes the JSON files, from the root down. @return the tiles whose GLB files are to be written; tiles with
/// equal payloads share a file.
std::vector<store::CutItem> writePages(const store::Reader& reader, const TileWriter& writer,
                                       AtomicFolder& folder, TileExportReport& report) {
  std::vector<store::CutItem> items;
  std::vector<bool> is_known(size_t{reader.blobCount()} + 1);
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
      const uint32_t blob = reader.nodes()[item.node].lods[item.lod].payload.number;
      if (!is_known[blob]) items.push_back(item);
      is_known[blob] = true;
    }
  }
  return items;
}

/// Writes GLB files on several threads.
class GlbFiles {
 public:
  GlbFiles(const TileWriter& writer, const AtomicFolder& folder, std::span<const store::CutItem> items)
      : writer_(writer), folder_(folder), items_(items) {}

  void writeAll(unsigned threads, const TileExportProgress& progress) {
    {
      const auto others = threads > 1 ? startThreads(threads - 1, "to write tiles", [this] { help(); })
                                      : std::vector<std::jthread>();
      try {
        do progress(done_, items_.size());
        while (writeNext());
      } catch (...) {
        fail(std::current_exception());
      }
    }
    if (failure_) std::rethrow_exception(failure_);
    progress(done_, items_.size());
  }
  uint64_t bytes() const noexcept { return bytes_; }

 private:
  void help() noexcept {
    try {
      while (writeNext()) continue;
    } catch (...) {
      fail(std::current_exception());
    }
  }

  /// Writes the next file. @return false if none is left, or if a thread has failed.
  bool writeNext() {
    const size_t number = is_failed_ ? items_.size() : next_++;
    if (number >= items_.size()) return false;
    const std::vector<std::byte> glb = writer_.glb(items_[number]);
    folder_.write(writer_.glbName(items_[number]), glb);
    bytes_ += glb.size();
    ++done_;
    return true;
  }

  void fail(std::exception_ptr failure) noexcept {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
    is_failed_ = true;
  }

  const TileWriter& writer_;
  const AtomicFolder& folder_;
  const std::span<const store::CutItem> items_;
  std::atomic<size_t> next_ = 0;
  std::atomic<uint64_t> done_ = 0, bytes_ = 0;
  std::atomic<bool> is_failed_ = false;
  std::mutex mutex_;
  std::exception_ptr failure_;  ///< first failure; guarded by mutex_ while threads run
};

}  // namespace

TileExportReport exportTiles(const store::Reader& reader, const TileExportOptions& options,
                             const TileExportProgress& progress) {
  AtomicFolder folder(options.folder);
  const TileWriter writer(reader, options.root_transform);
  TileExportReport report;
  const std::vector<store::CutItem> items = writePages(reader, writer, folder, report);
  if (!items.empty()) folder.makeFolder("g");
  GlbFiles files(writer, folder, items);
  files.writeAll(options.threads, progress);
  report.glbs = items.size();
  report.glb_bytes = files.bytes();
  folder.commit();
  return report;
}

}  // namespace lode::tiles
