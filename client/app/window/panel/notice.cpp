#include "client/app/window/panel/notice.h"

#include <algorithm>

#include "client/app/cli/remedy_words.h"

namespace lode::app {
namespace {

/// Joins lines below a heading, or returns the heading, the key that shows all lines, and the first line.
std::string headed(const std::string& heading, std::span<const std::string> lines, bool all) {
  if (!all) return heading + " (M: show all): " + lines.front();
  std::string text = heading + " (M: show less):";
  for (const std::string& line : lines) text += "\n" + line;
  return text;
}

std::string counted(size_t count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
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

std::string warningOf(std::span<const std::string> warnings, bool all) {
  return warnings.empty() ? "" : headed(counted(warnings.size(), "build warning"), warnings, all);
}

std::string missingText(std::span<const std::string> missing, bool all) {
  return missing.empty() ? "" : headed(counted(missing.size(), "missing model"), missing, all);
}

std::string hiddenText(std::span<const std::string> names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "hidden: " : ", ") + name;
  return text;
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
