#pragma once

#include <array>
#include <cstddef>
#include <memory_resource>

namespace lode::serve {

/// Memory of the open requests of one thread's connections: small pieces of slabs, each of pieces of one
/// size. A slab with no piece in use serves whoever asks next, so that a request takes no memory from the
/// system; more than kMaxKeptBytes of such go back at once, so that a flood of requests leaves nothing
/// behind. Not thread safe.
class RequestMemory : public std::pmr::memory_resource {
 public:
  static constexpr size_t kSlabBytes = 16u << 10, kMaxKeptBytes = 1u << 20;

  explicit RequestMemory(std::pmr::memory_resource* system = std::pmr::new_delete_resource()) noexcept
      : system_(system) {}
  /// All pieces have come back.
  ~RequestMemory() override;
  RequestMemory(const RequestMemory&) = delete;
  RequestMemory& operator=(const RequestMemory&) = delete;

 private:
  static constexpr size_t kStep = alignof(void*), kMaxPieceBytes = 128;  ///< larger ones: hash tables
  struct Slab;
  struct Piece {  ///< stands before what is given out
    Slab* slab;
    Piece* next;  ///< of those that came back; lies in what is given out
  };
  struct Slab {
    Slab *before, *after;                  ///< in the list of its size
    Piece* free;                           ///< came back
    size_t piece_bytes, in_use, fresh_at;  ///< what lies from fresh_at on was never in use
  };

  static bool isPiece(size_t bytes, size_t alignment) noexcept {
    return bytes > 0 && bytes <= kMaxPieceBytes && alignment <= kStep;
  }
  static bool isFull(const Slab& slab) noexcept {
    return slab.free == nullptr && slab.fresh_at + slab.piece_bytes > kSlabBytes;
  }
  Slab*& ofSize(size_t piece_bytes) noexcept { return slabs_[piece_bytes / kStep]; }
  Slab* emptySlab(size_t piece_bytes);
  void link(Slab& slab) noexcept;
  void unlink(Slab& slab) noexcept;
  void releaseStorage(Slab& slab) noexcept { system_->deallocate(&slab, kSlabBytes); }

  void* do_allocate(size_t bytes, size_t alignment) override;
  void do_deallocate(void* memory, size_t bytes, size_t alignment) override;
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

  std::pmr::memory_resource* system_;
  std::array<Slab*, kMaxPieceBytes / kStep + 2> slabs_{};  ///< with room, by their pieces' size
  Slab* kept_ = nullptr;                                   ///< with no piece in use, a list by `after`
  size_t kept_bytes_ = 0;
};

}  // namespace lode::serve
