#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/serve/session.h"
#include "server/store/reader.h"

namespace lode::serve {

/// How reading a chunk went.
enum class ReadResult {
  kDone,
  kCold,     ///< not in the page cache, or its blob not checked yet: readCold() may wait for the disk
  kDamaged,  ///< the blob's checksum does not match, or the file is shorter than it was
  kFailed,   ///< the operating system refused
};

/// The stores that a server offers, in the order of their names. Thread safe.
class ModelSet {
 public:
  /// @param stores  .lode files and folders of them. @param log  one line for the operator, from any thread.
  /// @throws Error kUsage, kIo, kFormat.
  ModelSet(std::span<const std::filesystem::path> stores, std::function<void(std::string_view)> log);

  std::span<const OfferedModel> offered() const noexcept { return offered_; }

  /// Reads a chunk without ever waiting for the disk. @param into  chunk.bytes long.
  ReadResult readHot(const Chunk& chunk, std::span<std::byte> into) const noexcept;
  /// Reads a chunk, waiting if it must; the first time a blob is touched all of it, to check it.
  ReadResult readCold(const Chunk& chunk, std::span<std::byte> into) const noexcept;

 private:
  enum class Trust : uint8_t { kUnchecked, kGood, kDamaged };
  struct Source {
    store::Reader reader;
    std::unique_ptr<std::atomic<Trust>[]> trust;  ///< by blob number
  };
  void add(const std::filesystem::path& file);
  ReadResult report(const Chunk& chunk, ReadResult result, std::string_view why) const noexcept;

  std::vector<OfferedModel> offered_;
  std::vector<Source> sources_;
  std::function<void(std::string_view)> log_;
};

}  // namespace lode::serve
