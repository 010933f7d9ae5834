#include "server/serve/memory/memory_budget.h"

#include <algorithm>
#include <utility>

#include "common/memory_limit.h"

namespace lode::serve {

uint64_t defaultMemoryBudget(const std::filesystem::path& root) { return memoryLimitBytes(root) / 8; }

uint64_t MemoryBudget::mean() const noexcept {
  return used() / std::max<uint64_t>(1, accounts_.load(std::memory_order_relaxed));
}

uint64_t MemoryBudget::staying() const noexcept {
  const uint64_t leaving = leaving_.load(std::memory_order_relaxed), used = this->used();
  return used - std::min(used, leaving);
}

bool MemoryBudget::take(uint64_t bytes, uint64_t up_to) noexcept {
  uint64_t used = used_.load(std::memory_order_relaxed);
  do {
    if (used + bytes > up_to) return false;
  } while (!used_.compare_exchange_weak(used, used + bytes, std::memory_order_relaxed));
  return true;
}

MemoryAccount::MemoryAccount(MemoryAccount&& other) noexcept
    : budget_(other.budget_),
      base_(std::exchange(other.base_, 0)),
      held_(std::exchange(other.held_, 0)),
      leaving_(std::exchange(other.leaving_, false)) {}

bool MemoryAccount::admit(uint64_t base_bytes) noexcept {
  if (!budget_->take(base_bytes, budget_->limit() / 8 * 7)) return false;
  if (base_ == 0) budget_->accounts_.fetch_add(1, std::memory_order_relaxed);
  base_ += base_bytes;
  return true;
}

MemoryAccount::~MemoryAccount() {
  if (base_ > 0) budget_->accounts_.fetch_sub(1, std::memory_order_relaxed);
  if (leaving_) budget_->leaving_.fetch_sub(held(), std::memory_order_relaxed);
  budget_->used_.fetch_sub(base_ + held_, std::memory_order_relaxed);
}

bool MemoryAccount::tryTake(uint64_t bytes) noexcept {
  if (leaving_) return false;
  if (held_ + bytes > kPoliteBytes) {
    const uint64_t for_large = budget_->limit() / 4 * 3;
    const uint64_t left = for_large - std::min(for_large, budget_->used());
    if (held_ + bytes > left / kLargeDivisor) return false;
  }
  const uint64_t limit = budget_->limit();
  if (!budget_->take(bytes, held_ + bytes > kModestBytes ? limit / 16 * 15 : limit)) return false;
  held_ += bytes;
  return true;
}

void MemoryAccount::take(uint64_t bytes) noexcept {
  budget_->used_.fetch_add(bytes, std::memory_order_relaxed);
  if (leaving_) budget_->leaving_.fetch_add(bytes, std::memory_order_relaxed);
  held_ += bytes;
}

void MemoryAccount::give(uint64_t bytes) noexcept {
  bytes = std::min(bytes, held_);
  if (leaving_) budget_->leaving_.fetch_sub(bytes, std::memory_order_relaxed);
  budget_->used_.fetch_sub(bytes, std::memory_order_relaxed);
  held_ -= bytes;
}

void MemoryAccount::leave() noexcept {
  if (std::exchange(leaving_, true)) return;
  budget_->leaving_.fetch_add(held(), std::memory_order_relaxed);
}

}  // namespace lode::serve
