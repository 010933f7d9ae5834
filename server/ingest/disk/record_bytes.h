#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/error.h"

namespace lode::ingest {

/// Serializes values in native byte order. Portability is not needed: only the same build, or a later one
/// that resumes it, reads the bytes.
class RecordWriter {
 public:
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { putBytes(std::as_bytes(std::span(&value, 1))); }
  /// Writes the number of items, then the items.
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void putAll(const std::vector<T>& items) {
    put(static_cast<uint64_t>(items.size()));
    putBytes(std::as_bytes(std::span(items)));
  }
  void putText(std::string_view text) {
    put(static_cast<uint64_t>(text.size()));
    putBytes(std::as_bytes(std::span(text)));
  }

  void putTexts(const std::vector<std::string>& texts) {
    put(static_cast<uint64_t>(texts.size()));
    for (const std::string& text : texts) putText(text);
  }
  /// Appends the bytes of another record, without a length.
  void append(std::span<const std::byte> bytes) { putBytes(bytes); }

  std::span<const std::byte> bytes() const noexcept { return bytes_; }

 private:
  void putBytes(std::span<const std::byte> bytes) {
    const size_t before = bytes_.size();
    bytes_.resize(before + bytes.size());
    if (!bytes.empty()) std::memcpy(bytes_.data() + before, bytes.data(), bytes.size());
  }

  std::vector<std::byte> bytes_;
};

/// Reads what a RecordWriter wrote. Checks every length against the remaining bytes before it allocates
/// memory. All functions throw Error kFormat.
class RecordReader {
 public:
  explicit RecordReader(std::span<const std::byte> bytes) : left_(bytes) {}

  template <typename T>
  requires std::is_trivially_copyable_v<T> T get() {
    T value;
    const auto bytes = take(sizeof(T));
    std::memcpy(static_cast<void*>(&value), bytes.data(), sizeof(T));
    return value;
  }
  template <typename T>
  requires std::is_trivially_copyable_v<T> std::vector<T> getAll() {
    std::vector<T> items(count(sizeof(T)));
    const auto bytes = take(items.size() * sizeof(T));
    if (!bytes.empty()) std::memcpy(static_cast<void*>(items.data()), bytes.data(), bytes.size());
    return items;
  }
  std::string getText() {
    const auto bytes = take(count(1));
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::vector<std::string> getTexts() {
    std::vector<std::string> texts(count(sizeof(uint64_t)));
    for (std::string& text : texts) text = getText();
    return texts;
  }
  bool atEnd() const noexcept { return left_.empty(); }

 private:
  size_t count(size_t item_bytes) {
    const auto items = get<uint64_t>();
    if (items > left_.size() / item_bytes) fail();
    return static_cast<size_t>(items);
  }
  std::span<const std::byte> take(size_t bytes) {
    if (bytes > left_.size()) fail();
    const auto taken = left_.first(bytes);
    left_ = left_.subspan(bytes);
    return taken;
  }
  [[noreturn]] static void fail() {
    throw Error(ErrorCode::kFormat, "the build's journal has a truncated record; build without --resume");
  }

  std::span<const std::byte> left_;
};

}  // namespace lode::ingest
