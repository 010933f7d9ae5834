#include "server/ingest/disk/record_sorter.h"

#include <algorithm>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include "common/release_storage.h"

namespace lode::ingest {
namespace {

/// Number of records that are sorted or written between two progress reports.
constexpr size_t kPieceRecords = 1 << 18;

}  // namespace

struct RecordSorter::Run {
  uint64_t begin = 0, end = 0;  ///< byte offsets in the spool
  std::optional<SpoolCursor> cursor;
  uint64_t key = 0;
  std::span<const std::byte> record;

  bool advance(size_t record_bytes) {
    if (cursor->atEnd()) return false;
    const auto bytes = cursor->take(sizeof(key) + record_bytes);
    std::memcpy(&key, bytes.data(), sizeof(key));
    record = bytes.subspan(sizeof(key));
    return true;
  }
};

RecordSorter::RecordSorter(size_t record_bytes, uint64_t memory_bytes, TemporaryFile runs, unsigned threads)
    : record_bytes_(record_bytes),
      memory_bytes_(memory_bytes),
      capacity_(std::clamp<size_t>(memory_bytes / (record_bytes + sizeof(Order)), 1024, UINT32_MAX)),
      file_(std::move(runs)),
      threads_(threads) {}

RecordSorter::~RecordSorter() = default;

void RecordSorter::reserve(uint64_t records) {
  const size_t held = std::min<uint64_t>(capacity_, records);
  order_.reserve(held);
  held_.reserve(held * record_bytes_);
}

void RecordSorter::push(uint64_t key, std::span<const std::byte> record) {
  if (order_.size() == capacity_) spill();
  if (order_.size() == order_.capacity()) reserve(std::max<size_t>(1024, order_.size() * 3 / 2));
  order_.push_back({key, static_cast<uint32_t>(order_.size())});
  held_.insert(held_.end(), record.begin(), record.end());
  ++size_;
}

bool RecordSorter::later(uint32_t a, uint32_t b) const noexcept {
  return std::pair(runs_[a]->key, a) > std::pair(runs_[b]->key, b);
}

/// Sorts a range of order_ on several threads. Only the calling thread, which sorts the smallest keys,
/// reports progress.
void RecordSorter::sortOn(unsigned threads, size_t begin, size_t end, const Progress& progress,
                          uint64_t total) {
  if (threads < 2 || end - begin <= 2 * kPieceRecords) return sortPieces(begin, end, progress, total);
  const unsigned lower_threads = threads / 2;
  const size_t middle = begin + (end - begin) / threads * lower_threads;
  const auto at = [this](size_t index) { return order_.begin() + static_cast<ptrdiff_t>(index); };
  std::nth_element(at(begin), at(middle), at(end));
  const auto sortUpper = [=, this] { sortOn(threads - lower_threads, middle, end, {}, total); };
  std::jthread upper;
  try {
    upper = std::jthread(sortUpper);
  } catch (const std::system_error&) {
    sortUpper();
  }
  sortOn(lower_threads, begin, middle, progress, total);
}

/// Sorts a range of order_ piece by piece, and reports progress after each piece.
void RecordSorter::sortPieces(size_t begin, size_t end, const Progress& progress, uint64_t total) {
  const auto at = [this](size_t index) { return order_.begin() + static_cast<ptrdiff_t>(index); };
  if (end - begin > kPieceRecords) {
    const size_t middle = begin + (end - begin) / 2;
    std::nth_element(at(begin), at(middle), at(end));
    sortPieces(begin, middle, progress, total);
    sortPieces(middle, end, progress, total);
    return;
  }
  std::sort(at(begin), at(end));
  sorted_ += end - begin;
  if (progress) progress(sorted_, total);
}

void RecordSorter::spill(const Progress& progress) {
  const uint64_t total = 2 * order_.size();
  sorted_ = 0;
  sortOn(threads_, 0, order_.size(), progress, total);
  if (!spool_) spool_.emplace(file_);
  auto run = std::make_unique<Run>();
  run->begin = spool_->size();
  uint64_t written = 0;
  for (const Order& at : order_) {
    spool_->append(std::as_bytes(std::span(&at.key, 1)));
    spool_->append(std::span<const std::byte>(held_.data() + at.index * record_bytes_, record_bytes_));
    if (progress && ++written % kPieceRecords == 0) progress(order_.size() + written, total);
  }
  run->end = temporary_bytes_ = spool_->size();
  runs_.push_back(std::move(run));
  order_.clear();
  held_.clear();
}

void RecordSorter::save(RecordWriter& record) {
  std::vector<uint64_t> ends;
  for (const auto& run : runs_) ends.push_back(run->end);
  record.putAll(ends);
  if (!spool_) return;
  spool_->flush();
  spool_->sync();
}

void RecordSorter::restore(RecordReader& record) {
  const size_t entry_bytes = sizeof(uint64_t) + record_bytes_;
  uint64_t begin = 0;
  for (const uint64_t end : record.getAll<uint64_t>()) {
    if (end <= begin || end % entry_bytes != 0) {
      throw Error(ErrorCode::kFormat,
                  "the build's journal has a damaged list of sorted runs; build without --resume");
    }
    runs_.push_back(std::make_unique<Run>());
    runs_.back()->begin = begin;
    runs_.back()->end = begin = end;
  }
  if (runs_.empty()) return;
  spool_.emplace(file_, begin);
  temporary_bytes_ = begin;
  size_ = begin / entry_bytes;
}

void RecordSorter::finish(const Progress& progress) {
  if (runs_.empty()) {
    sortOn(threads_, 0, order_.size(), progress, order_.size());
    return;
  }
  if (!order_.empty()) spill(progress);
  releaseStorage(order_);
  releaseStorage(held_);
  spool_->flush();
  const size_t buffer_bytes = std::clamp<size_t>(memory_bytes_ / runs_.size(), 64 << 10, 4 << 20);
  for (uint32_t i = 0; i < runs_.size(); ++i) {
    runs_[i]->cursor.emplace(*spool_, runs_[i]->begin, runs_[i]->end, buffer_bytes);
    if (runs_[i]->advance(record_bytes_)) heap_.push_back(i);
  }
  std::make_heap(heap_.begin(), heap_.end(), [this](uint32_t a, uint32_t b) { return later(a, b); });
}

std::optional<RecordSorter::Record> RecordSorter::next() {
  return runs_.empty() ? nextOfMemory() : nextOfRuns();
}

std::optional<RecordSorter::Record> RecordSorter::nextOfMemory() {
  if (next_held_ == order_.size()) return std::nullopt;
  const Order& at = order_[next_held_++];
  return Record{at.key, std::span<const std::byte>(held_.data() + at.index * record_bytes_, record_bytes_)};
}

std::optional<RecordSorter::Record> RecordSorter::nextOfRuns() {
  const auto order = [this](uint32_t a, uint32_t b) { return later(a, b); };
  // The caller has finished with the last returned record. Advance the record's run, which is still on top of
  // the heap.
  if (top_given_) {
    std::pop_heap(heap_.begin(), heap_.end(), order);
    if (runs_[heap_.back()]->advance(record_bytes_)) {
      std::push_heap(heap_.begin(), heap_.end(), order);
    } else {
      runs_[heap_.back()].reset();
      heap_.pop_back();
    }
  }
  top_given_ = !heap_.empty();
  if (heap_.empty()) {
    spool_.reset();
    return std::nullopt;
  }
  const Run& run = *runs_[heap_.front()];
  return Record{run.key, run.record};
}

}  // namespace lode::ingest
