#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include "client/core/time_point.h"
#include "proto/messages.h"

namespace lode::app {

/// How long the wishes of one connection take, by the frames that its client sends. Not thread safe.
class WishClock {
 public:
  struct Wish {
    uint32_t number;
    proto::WishClass wish_class;
    core::TimePoint sent;
  };

  /// By blob.
  using Wishes = std::map<uint32_t, Wish>;

  /// Whole frames. @param lost  of connections that broke off: those made again here leave it, and count from
  /// when they were sent first.
  void sent(std::span<const std::byte> frames, core::TimePoint now, Wishes& lost);
  /// @return the wish for a blob that has come; none if it came unasked.
  std::optional<Wish> arrived(uint32_t blob);
  /// The blob will not come.
  void refused(uint32_t blob) { arrived(blob); }
  /// Those that have not come.
  const Wishes& open() const noexcept { return open_; }

 private:
  Wishes open_;
  std::map<uint32_t, uint32_t> blob_of_;  ///< by wish
};

}  // namespace lode::app
