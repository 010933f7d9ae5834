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

/// The IPv4 address that one in IPv6's form stands for, as a socket of both kinds has it; others as they are.
asio::ip::address plainAddress(const asio::ip::address& address);

/// A connection's place among those that a server takes; given back at the end, wherever that is.
class Place {
 public:
  Place(Place&& other) noexcept;
  Place& operator=(Place&&) = delete;
  ~Place();

  /// Counts it under an address. @return false if that has as many as it may.
  bool countUnder(const asio::ip::address& address);
  /// Counts it in the load of the thread that serves it.
  void countIn(std::atomic<uint32_t>& load) noexcept;

 private:
  friend class Admission;
  explicit Place(Admission& admission) noexcept : admission_(&admission) {}

  Admission* admission_;
  std::optional<uint64_t> address_;
  std::atomic<uint32_t>* load_ = nullptr;
};

/// How many connections there are, in total and by address. Thread safe; it outlives its places.
class Admission {
 public:
  /// @param per_address  of IPv6 a network of 64 bits counts as one; none: loopback is not limited, others to
  /// kMaxConnectionsPerAddress.
  Admission(uint32_t total, std::optional<uint32_t> per_address);

  /// @return nothing if there are as many as there may be.
  std::optional<Place> enter();
  uint32_t count() const;
  uint32_t total() const noexcept { return total_; }

  /// Calls `empty` once, when no connection is left; at once if there is none. Called from any thread.
  void whenEmpty(std::function<void()> empty);

 private:
  friend class Place;
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
