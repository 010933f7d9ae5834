#include "server/serve/session/request_memory.h"

#include <new>
#include <utility>

namespace lode::serve {

namespace {

constexpr size_t kHeadBytes = sizeof(void*);  ///< of a piece: the slab that it belongs to

}  // namespace

RequestMemory::~RequestMemory() {
  while (kept_ != nullptr) releaseStorage(*std::exchange(kept_, kept_->after));
}

RequestMemory::Slab* RequestMemory::emptySlab(size_t piece_bytes) {
  void* memory = kept_;
  if (kept_ != nullptr) {
    kept_ = kept_->after;
    kept_bytes_ -= kSlabBytes;
  } else {
    memory = system_->allocate(kSlabBytes);
  }
  // NOLINTNEXTLINE(cppcoreguidelines-owning-memory): it is placed, and the system's
  return new (memory) Slab{nullptr, nullptr, nullptr, piece_bytes, 0, sizeof(Slab)};
}

void RequestMemory::link(Slab& slab) noexcept {
  Slab*& first = ofSize(slab.piece_bytes);
  slab.before = nullptr;
  slab.after = std::exchange(first, &slab);
  if (slab.after != nullptr) slab.after->before = &slab;
}

void RequestMemory::unlink(Slab& slab) noexcept {
  (slab.before != nullptr ? slab.before->after : ofSize(slab.piece_bytes)) = slab.after;
  if (slab.after != nullptr) slab.after->before = slab.before;
}

void* RequestMemory::do_allocate(size_t bytes, size_t alignment) {
  if (!isPiece(bytes, alignment)) return system_->allocate(bytes, alignment);
  const size_t piece_bytes = kHeadBytes + (bytes + kStep - 1) / kStep * kStep;
  if (ofSize(piece_bytes) == nullptr) link(*emptySlab(piece_bytes));
  Slab& slab = *ofSize(piece_bytes);
  std::byte* piece = reinterpret_cast<std::byte*>(slab.free);
  if (slab.free != nullptr) {
    slab.free = slab.free->next;
  } else {
    piece = reinterpret_cast<std::byte*>(&slab) + std::exchange(slab.fresh_at, slab.fresh_at + piece_bytes);
    new (piece) Slab*(&slab);
  }
  ++slab.in_use;
  if (isFull(slab)) unlink(slab);
  return piece + kHeadBytes;
}

void RequestMemory::do_deallocate(void* memory, size_t bytes, size_t alignment) {
  if (!isPiece(bytes, alignment)) return system_->deallocate(memory, bytes, alignment);
  auto* const piece = reinterpret_cast<Piece*>(static_cast<std::byte*>(memory) - kHeadBytes);
  Slab& slab = *piece->slab;
  if (isFull(slab)) link(slab);
  piece->next = std::exchange(slab.free, piece);
  if (--slab.in_use > 0) return;
  unlink(slab);
  if (kept_bytes_ + kSlabBytes > kMaxKeptBytes) return releaseStorage(slab);
  slab.after = std::exchange(kept_, &slab);
  kept_bytes_ += kSlabBytes;
}

}  // namespace lode::serve
