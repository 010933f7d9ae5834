#include "client/app/window/panel/notice.h"

#include <algorithm>

#include "client/app/cli/remedy_words.h"

namespace lode::app {
namespace {

constexpr size_t kMostMissing = 3;

/// Joins the first `most` lines, and adds a line with the number of the remaining lines. @param lines  at
/// least one line.
std::string firstOf(std::span<const std::string> lines, size_t most) {
  std::string text = lines.front();
  for (const std::string& line : lines.first(std::min(most, lines.size())).subspan(1)) text += "\n" + line;
  if (lines.size() > most) text += "\nand " + std::to_string(lines.size() - most) + " more, on stderr";
  return text;
}

constexpr float kDotPx = 8;

std::string failureText(const stream::StreamStatus& status) {
  const std::string failure = withRemedy(status.failure, status.failure_remedy);
  if (status.failure_may_pass)
    return failure + (status.cut ? "\nThat part stays at lower detail meanwhile; the view tries again."
                                 : "\nThe view tries again.");
  if (!status.cut) return failure;
  return failure + (status.ended ? "\nThe view keeps what is loaded; no more detail will load."
                                 : "\nThat part stays at lower detail.");
}

}  // namespace

Notice noticeOf(const stream::StreamStatus& status, bool offline, OnGpu on_gpu) {
  using enum Notice::Kind;
  if (status.exhausted && status.cut)
    return {kTrouble,
            "offline: the cache has no finer detail of this view; start once without --offline to load more"};
  if (!status.failure.empty()) return {status.failure_may_pass ? kTrouble : kFailure, failureText(status)};
  if (!status.trouble.empty())
    return {kTrouble, "no connection: " + withRemedy(status.trouble, status.trouble_remedy) +
                          "\nThe view keeps what is loaded and reconnects automatically."};
  if (on_gpu == OnGpu::kFull)
    return {kTrouble,
            "no GPU memory for more detail: raise the memory in the settings (O) or with --memory-budget, or "
            "press - for a coarser view"};
  if (status.settled && status.limited && on_gpu == OnGpu::kAll)
    return {kTrouble,
            "no memory for more detail: raise the memory in the settings (O) or with --memory-budget"};
  if (!offline) return {};
  const bool is_complete = status.cut && status.cut->converged;
  if (status.settled && !is_complete)
    return {kTrouble,
            "offline: parts of this view are not in the cache; start again without --offline to load them"};
  return {kHint, "offline: using the cache only"};
}

std::string warningOf(std::span<const std::string> warnings) {
  return warnings.empty() ? "" : "build warning: " + firstOf(warnings, 1);
}

std::string missingText(std::span<const std::string> missing) {
  return missing.empty() ? "" : firstOf(missing, kMostMissing) + "\nThe rest of the scene is shown.";
}

Notice noticeOf(const Error& error) {
  return {Notice::Kind::kFailure, messageOf(error) + "\nEsc or Q closes the window."};
}

std::string_view lostSightText(const core::ModelBox& model, const core::View& view) {
  if (!core::boxMayBeVisible(model, view)) return "the model is out of view; R resets the view";
  const auto size_model = static_cast<float>(glm::distance(model.min, model.max));
  if (core::screenErrorPx(size_model, core::distanceToBox(view.eye_model, model), view) < kDotPx)
    return "the model is a dot from here; R resets the view";
  return "";
}

}  // namespace lode::app
