#include "server/serve/net/admission.h"

#include <utility>

#include "proto/limits.h"

namespace lode::serve {

uint64_t addressKey(const asio::ip::address& address) {
  const asio::ip::address plain = plainAddress(address);
  if (plain.is_v4()) return plain.to_v4().to_uint();
  const auto bytes = plain.to_v6().to_bytes();
  uint64_t network = 0;
  for (size_t i = 0; i < 8; ++i) network = network << 8 | bytes[i];
  return network | uint64_t{1} << 63;  // the highest bit distinguishes the key from all IPv4 keys
}

asio::ip::address plainAddress(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
}

Slot::Slot(Slot&& other) noexcept
    : admission_(std::exchange(other.admission_, nullptr)),
      address_(std::exchange(other.address_, {})),
      load_(std::exchange(other.load_, nullptr)) {}

Slot::~Slot() {
  if (load_ != nullptr) load_->fetch_sub(1, std::memory_order_relaxed);
  if (admission_ != nullptr) admission_->leave(address_);
}

void Slot::countIn(std::atomic<uint32_t>& load) noexcept {
  load.fetch_add(1, std::memory_order_relaxed);
  load_ = &load;
}

bool Slot::countUnder(const asio::ip::address& address) {
  const uint64_t key = addressKey(address);
  if (!admission_->countUnder(key, plainAddress(address).is_loopback())) return false;
  address_ = key;
  return true;
}

Admission::Admission(uint32_t total, std::optional<uint32_t> per_address)
    : total_(total), per_address_(per_address) {}

std::optional<Slot> Admission::enter() {
  const std::lock_guard lock(mutex_);
  if (count_ >= total_) return {};
  ++count_;
  return Slot(*this);
}

uint32_t Admission::count() const {
  const std::lock_guard lock(mutex_);
  return count_;
}

void Admission::whenEmpty(std::function<void()> empty) {
  {
    const std::lock_guard lock(mutex_);
    if (count_ > 0) {
      empty_ = std::move(empty);
      return;
    }
  }
  empty();
}

bool Admission::countUnder(uint64_t address, bool loopback) {
  const uint32_t most = per_address_ ? *per_address_ : loopback ? total_ : proto::kMaxConnectionsPerAddress;
  const std::lock_guard lock(mutex_);
  uint32_t& count = addresses_[address];
  if (count >= most) return false;
  ++count;
  return true;
}

void Admission::leave(const std::optional<uint64_t>& address) noexcept {
  std::function<void()> empty;
  {
    const std::lock_guard lock(mutex_);
    if (address) {
      const auto counted = addresses_.find(*address);
      if (--counted->second == 0) addresses_.erase(counted);
    }
    if (--count_ == 0) empty.swap(empty_);
  }
  if (empty) empty();
}

}  // namespace lode::serve
