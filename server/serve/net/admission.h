#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <unordered_map>

#include <asio/ip/address.hpp>

namespace lode::serve {

class Admission;

/// Converts an IPv4-mapped IPv6 address, which dual-stack sockets report, to the IPv4 address. Returns other
/// addresses unchanged.
asio::ip::address plainAddress(const asio::ip::address& address);

/// Returns a number that identifies an IPv4 address, or the /64 network of an IPv6 address.
uint64_t addressKey(const asio::ip::address& address);

/// One connection's place within the limits of Admission. The destructor frees the place.
class Slot {
 public:
  Slot(Slot&& other) noexcept;
  Slot& operator=(Slot&&) = delete;
  ~Slot();

  /// Counts the connection under an address. @return false if the address already has the maximum of
  /// connections.
  bool countUnder(const asio::ip::address& address);
  /// Counts the connection in `load`, the number of connections of a thread, until the slot is destroyed.
  void countIn(std::atomic<uint32_t>& load) noexcept;

 private:
  friend class Admission;
  explicit Slot(Admission& admission) noexcept : admission_(&admission) {}

  Admission* admission_;
  std::optional<uint64_t> address_;
  std::atomic<uint32_t>* load_ = nullptr;
};

/// Limits the number of connections, in total and per address. Must outlive its slots. Thread safe.
class Admission {
 public:
  /// @param per_address  limit per IPv4 address or IPv6 /64 network. If the limit is not set, it is
  /// kMaxConnectionsPerAddress, except that loopback has no limit.
  Admission(uint32_t total, std::optional<uint32_t> per_address);

  /// Admits a connection. @return a slot, or nothing if the total limit is reached.
  std::optional<Slot> enter();
  uint32_t count() const;
  uint32_t total() const noexcept { return total_; }

  /// Calls `empty` once, as soon as no connection is left, which may be at once. The call comes from the
  /// thread that frees the last slot.
  void whenEmpty(std::function<void()> empty);

 private:
  friend class Slot;
  void leave(const std::optional<uint64_t>& address) noexcept;
  bool countUnder(uint64_t address, bool loopback);

  uint32_t total_;
  std::optional<uint32_t> per_address_;
  mutable std::mutex mutex_;
  uint32_t count_ = 0;
  std::unordered_map<uint64_t, uint32_t> addresses_;
  std::function<void()> empty_;
};

}  // namespace lode::serve
