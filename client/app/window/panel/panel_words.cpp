#include "client/app/window/panel/panel_words.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <imgui.h>

#include "client/app/cli/build_step.h"
#include "client/app/window/panel/panel_window.h"

namespace lode::app {
namespace {

constexpr const char* kCancel = "Esc cancels";
constexpr const char* kCutOff = "...";

/// Returns true if the text fits on a bar of this width. A longer text is drawn above the bar.
bool isOnBar(const std::string& text, float width_px) {
  return ImGui::CalcTextSize(text.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x <= width_px;
}

float thinBarPx() { return ImGui::GetFontSize() * 0.4f; }

struct Word {
  std::string text;
  ImVec4 colour;
};

std::vector<Word> wordsOf(const PanelContent& content, float width_px) {
  const Notice& notice = content.notice;
  const ImVec4& colour = notice.kind == Notice::Kind::kFailure   ? kBad
                         : notice.kind == Notice::Kind::kTrouble ? kWarning
                                                                 : kMuted;
  std::vector<Word> words{{content.title, ImGui::GetStyleColorVec4(ImGuiCol_Text)}};
  if (notice.kind != Notice::Kind::kNone) words.push_back({notice.text, colour});
  if (content.recording) words.push_back({"recording the camera path; P stops", kBad});
  if (!content.message.empty()) words.push_back({content.message, kWarning});
  const auto add = [&](const std::string& text, const ImVec4& its_colour) {
    if (!text.empty())
      words.push_back({content.shows_messages ? text : onOneLine(text, width_px), its_colour});
  };
  if (!content.visible) return words;
  add(content.hidden, kMuted);
  add(content.missing, kBad);
  add(content.warning, kWarning);
  if (!content.explanation.empty())
    words.push_back({std::string(content.show) + ": " + std::string(content.explanation), kMuted});
  return words;
}

}  // namespace

std::string onOneLine(std::string text, float width_px) {
  std::ranges::replace(text, '\n', ' ');
  const auto fits = [width_px](const std::string& line) {
    return ImGui::CalcTextSize(line.c_str()).x <= width_px;
  };
  if (fits(text)) return text;
  while (!text.empty() && !fits(text + kCutOff)) {
    while (text.size() > 1 && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80) text.pop_back();
    text.pop_back();
  }
  return text + kCutOff;
}

float textPx(const std::string& text, float width_px) {
  return ImGui::CalcTextSize(text.c_str(), nullptr, false, width_px).y;
}

float barPx(const std::string& text, float width_px) {
  if (isOnBar(text, width_px)) return ImGui::GetFrameHeight();
  return textPx(text, width_px) + ImGui::GetStyle().ItemSpacing.y + thinBarPx();
}

void drawBar(double part, const std::string& text, float width_px) {
  const bool is_on = isOnBar(text, width_px);
  if (!is_on) ImGui::TextUnformatted(text.c_str());
  const ImVec2 at = ImGui::GetCursorScreenPos(), padding = ImGui::GetStyle().FramePadding;
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, kBar);
  ImGui::ProgressBar(static_cast<float>(part), {width_px, is_on ? 0 : thinBarPx()}, "");
  ImGui::PopStyleColor();
  if (is_on)
    ImGui::GetWindowDrawList()->AddText({at.x + padding.x, at.y + padding.y},
                                        ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
}

void drawWords(const PanelContent& content, float width_px) {
  for (const Word& word : wordsOf(content, width_px))
    ImGui::TextColored(word.colour, "%s", word.text.c_str());
}

float wordsPx(const PanelContent& content, float width_px) {
  float height_px = 0;
  for (const Word& word : wordsOf(content, width_px))
    height_px += textPx(word.text, width_px) + ImGui::GetStyle().ItemSpacing.y;
  return height_px;
}

void drawWaiting(const PanelContent& content, float width_px) {
  ImGui::TextUnformatted(content.waiting.c_str());
  if (content.waiting_part >= 0) {
    drawBar(content.waiting_part, percentInWords(content.waiting_part), width_px);
    ImGui::TextColored(kMuted, "%s", kCancel);
    return;
  }
  const ImVec2 size(width_px, ImGui::GetFontSize() * 0.5f);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const auto phase = static_cast<float>(std::fmod(content.waited_s, 2.0) / 2.0);
  const float left = at.x + (size.x * 1.25f) * phase - size.x * 0.25f;
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 end(at.x + size.x, at.y + size.y);
  list->AddRectFilled(at, end, ImGui::GetColorU32(ImGuiCol_FrameBg), 3);
  list->PushClipRect(at, end, true);
  list->AddRectFilled({left, at.y}, {left + size.x * 0.25f, end.y},
                      ImGui::GetColorU32(ImGuiCol_PlotHistogram), 3);
  list->PopClipRect();
  ImGui::Dummy(size);
  ImGui::TextColored(kMuted, "%.0f s; %s", content.waited_s, kCancel);
}

}  // namespace lode::app
