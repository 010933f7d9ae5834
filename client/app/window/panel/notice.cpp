#include "client/app/window/panel/notice.h"

#include <algorithm>

namespace lode::app {
namespace {

constexpr size_t kMostMissing = 3;

/// @param lines  at least one.
std::string firstOf(std::span<const std::string> lines, size_t most) {
  std::string text = lines.front();
  for (const std::string& line : lines.first(std::min(most, lines.size())).subspan(1)) text += "\n" + line;
  if (lines.size() > most) text += "\nand " + std::to_string(lines.size() - most) + " more, on stderr";
  return text;
}

}  // namespace

Notice noticeOf(const stream::StreamStatus& status, bool offline, OnGpu on_gpu) {
  using enum Notice::Kind;
  if (status.exhausted && status.cut)
    return {
        kTrouble,
        "offline: shown as finely as the cache has it; once without --offline brings the rest of this view"};
  if (!status.failure.empty() && !status.cut) return {kFailure, status.failure};
  if (!status.failure.empty())
    return {kFailure, status.failure + (status.ended ? "\nWhat is here stays; nothing more will come."
                                                     : "\nThe picture does without that part.")};
  if (!status.trouble.empty())
    return {kTrouble,
            "no connection: " + status.trouble + "\nThe picture stays; it connects again by itself."};
  if (on_gpu == OnGpu::kFull)
    return {kTrouble,
            "no room on the GPU for more detail: allow more in the settings (O) or with --memory-budget, or "
            "a larger error (-)"};
  if (status.settled && status.limited && on_gpu == OnGpu::kAll)
    return {
        kTrouble,
        "the memory budget allows no more detail: allow more in the settings (O) or with --memory-budget"};
  if (!offline) return {};
  const bool is_all_there = status.cut && status.cut->converged;
  if (status.settled && !is_all_there)
    return {kTrouble, "offline: the cache has no more of this place; without --offline the server is asked"};
  return {kHint, "offline: from the cache alone"};
}

std::string warningOf(std::span<const std::string> warnings) {
  return warnings.empty() ? "" : "built with a warning: " + firstOf(warnings, 1);
}

std::string missingText(std::span<const std::string> missing) {
  return missing.empty() ? "" : firstOf(missing, kMostMissing) + "\nThe rest of the scene is shown.";
}

Notice noticeOf(const Error& error) {
  return {Notice::Kind::kFailure, std::string(error.what()) + "\nEsc or Q closes the window."};
}

}  // namespace lode::app
