#include "client/loadtest/load_counts.h"

#include "client/app/cli/remedy_words.h"

namespace lode::app {

void LoadCounts::add(const LoadCounts& other) {
  for (size_t i = 0; i < latency.size(); ++i) latency[i].add(other.latency[i]);
  first_image.add(other.first_image);
  converged.add(other.converged);
  looked_s += other.looked_s;
  far_off_s += other.far_off_s;
  started += other.started;
  blobs += other.blobs;
  bytes += other.bytes;
  unanswered += other.unanswered;
  moved += other.moved;
  turned_away += other.turned_away;
  lost += other.lost;
  failed_requests += other.failed_requests;
  gave_up += other.gave_up;
  for (const auto& [code, count] : other.errors) errors[code] += count;
  if (first_error.empty()) first_error = other.first_error;
}

void LoadCounts::noteError(const Error& error) {
  if (first_error.empty()) first_error = messageOf(error);
  ++errors[error.code()];
}

uint64_t LoadCounts::errorCount() const noexcept {
  uint64_t count = 0;
  for (const auto& [code, of_code] : errors) count += of_code;
  return count;
}

}  // namespace lode::app
