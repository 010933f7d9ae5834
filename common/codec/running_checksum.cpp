#include "common/codec/running_checksum.h"

#include <new>

#include <xxhash.h>

namespace lode {

struct RunningChecksum::State {
  XXH3_state_t* xxh3 = XXH3_createState();
  State() {
    if (xxh3 == nullptr) throw std::bad_alloc();
    XXH3_64bits_reset(xxh3);
  }
  ~State() { XXH3_freeState(xxh3); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

RunningChecksum::RunningChecksum() : state_(std::make_unique<State>()) {}
RunningChecksum::~RunningChecksum() = default;
RunningChecksum::RunningChecksum(RunningChecksum&&) noexcept = default;
RunningChecksum& RunningChecksum::operator=(RunningChecksum&&) noexcept = default;

void RunningChecksum::add(std::span<const std::byte> bytes) noexcept {
  XXH3_64bits_update(state_->xxh3, bytes.data(), bytes.size());
}

uint64_t RunningChecksum::value() const noexcept { return XXH3_64bits_digest(state_->xxh3); }

}  // namespace lode
