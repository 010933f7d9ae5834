#include "client/app/window/panel/panel.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "client/app/cli/build_step.h"
#include "client/app/window/panel/panel_figures.h"
#include "client/app/window/panel/panel_font.h"
#include "client/app/window/panel/panel_help.h"
#include "client/app/window/panel/panel_layout.h"
#include "client/app/window/panel/panel_window.h"
#include "client/app/window/panel/pick_marks.h"
#include "client/app/window/panel/sharpness.h"

namespace lode::app {
namespace {

constexpr float kNameEm = 5.5f;  ///< width of the column of names, in multiples of the font size
const ImVec4 kGood(0.55f, 0.85f, 0.60f, 1), kWarning(1.0f, 0.72f, 0.40f, 1), kBad(1.0f, 0.50f, 0.45f, 1),
    kBar(0.26f, 0.48f, 0.72f, 1);

float panelPx() { return fittingPx(panelWidthPx(ImGui::GetIO().DisplaySize.x, ImGui::GetFontSize())); }
float namePx() { return std::min(ImGui::GetFontSize() * kNameEm, panelPx() / 2); }
float valuePx() { return panelPx() - namePx(); }

float lineGapPx() { return ImGui::GetStyle().ItemSpacing.y; }

float textPx(const std::string& text, float width_px) {
  return ImGui::CalcTextSize(text.c_str(), nullptr, false, width_px).y;
}

/// Returns true if the text fits on a bar of this width. A longer text is drawn above the bar.
bool isOnBar(const std::string& text, float width_px) {
  return ImGui::CalcTextSize(text.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x <= width_px;
}

float thinBarPx() { return ImGui::GetFontSize() * 0.4f; }

float barPx(const std::string& text, float width_px) {
  if (isOnBar(text, width_px)) return ImGui::GetFrameHeight();
  return textPx(text, width_px) + lineGapPx() + thinBarPx();
}

/// Draws a progress bar with a text on it or above it.
void bar(double part, const std::string& text, float width_px) {
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

float heightOf(const Figure& figure) {
  const float name_px = textPx(figure.name, namePx());
  const float value_px = figure.part >= 0 ? barPx(figure.value, valuePx()) : textPx(figure.value, valuePx());
  return std::max(name_px, value_px) + 2 * ImGui::GetStyle().CellPadding.y;
}

void drawFigures(std::span<const Figure> figures, const std::vector<bool>& shown) {
  if (std::ranges::find(shown, true) == shown.end() ||
      !ImGui::BeginTable("figures", 2, ImGuiTableFlags_SizingFixedFit))
    return;
  // Fix the column widths, because widths that follow the contents would lag one frame behind.
  ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthFixed, namePx());
  ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthFixed, valuePx());
  ImGui::PushTextWrapPos(0);  // wraps at the end of the column
  for (size_t i = 0; i < figures.size(); ++i) {
    if (!shown[i]) continue;
    nameRow(figures[i].name);
    if (figures[i].part >= 0)
      bar(figures[i].part, figures[i].value, valuePx());
    else
      ImGui::TextUnformatted(figures[i].value.c_str());
  }
  ImGui::PopTextWrapPos();
  ImGui::EndTable();
}

/// Describes the sharpness of the picture or the progress of refinement. Returns an empty text if the notice
/// already describes the state.
std::string sharpnessOf(const PanelContent& content) {
  if (!content.lost.empty()) return std::string(content.lost);
  if (content.is_preview) return previewText(content.error_px);
  if (content.converged) return convergedText(content.error_px, content.threshold_px);
  if (content.limited) return limitedText(content.error_px);
  if (content.exhausted) return "";
  if (content.incomplete) return lackingText(content.error_px);
  if (content.waiting_for_server) return waitingText(content.error_px);
  return refiningText(
      {content.error_px, content.threshold_px, content.counts.requests.tiles, content.counts.received_bytes});
}

bool isRefining(const PanelContent& content) {
  return content.lost.empty() && !content.is_preview && !content.converged && !content.limited &&
         !content.exhausted && !content.incomplete && !content.waiting_for_server;
}

float sharpnessPx(const PanelContent& content) {
  const std::string text = sharpnessOf(content);
  if (text.empty()) return 0;
  return lineGapPx() + (isRefining(content) ? barPx(text, panelPx()) : textPx(text, panelPx()));
}

void drawSharpness(const PanelContent& content) {
  const std::string text = sharpnessOf(content);
  if (isRefining(content)) return bar(content.progress, text, panelPx());
  if (text.empty()) return;
  const ImVec4 plain = ImGui::GetStyleColorVec4(ImGuiCol_Text);
  ImGui::TextColored(!content.lost.empty() ? kWarning
                     : content.converged   ? kGood
                                           : plain,
                     "%s", text.c_str());
}

float frameTimesPx() { return ImGui::GetFontSize() * 3.5f + 2 * lineGapPx(); }

/// Draws a histogram of frame times with a line at the target.
void drawFrameTimes(std::span<const float> frames_ms, size_t oldest, double aimed_ms) {
  const auto aimed = static_cast<float>(aimed_ms);
  const float most_ms = std::max({1.0f, 1.25f * aimed, *std::ranges::max_element(frames_ms)});
  if (aimed > 0)
    ImGui::TextColored(kMuted, "frame times, up to %.0f ms; line: %.0f ms", static_cast<double>(most_ms),
                       aimed_ms);
  else
    ImGui::TextColored(kMuted, "frame times, up to %.0f ms", static_cast<double>(most_ms));
  const ImVec2 at = ImGui::GetCursorScreenPos(), size(panelPx(), ImGui::GetFontSize() * 2.5f);
  ImGui::PlotHistogram("##frames", frames_ms.data(), static_cast<int>(frames_ms.size()),
                       static_cast<int>(oldest), nullptr, 0, most_ms, size);
  if (aimed <= 0) return;
  const float inside = ImGui::GetStyle().FramePadding.y;
  const float y = at.y + size.y - inside - (size.y - 2 * inside) * aimed / most_ms;
  ImGui::GetWindowDrawList()->AddLine({at.x, y}, {at.x + size.x, y}, ImGui::GetColorU32(kGood));
}

float legendRowPx() { return ImGui::GetFontSize() + lineGapPx(); }

void drawLegend(std::span<const render::LegendEntry> legend) {
  if (legend.empty()) return;
  ImGui::Separator();
  for (const render::LegendEntry& entry : legend) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float side = ImGui::GetFontSize();
    ImGui::GetWindowDrawList()->AddRectFilled(
        at, {at.x + side, at.y + side}, IM_COL32(entry.colour.r, entry.colour.g, entry.colour.b, 255), 2);
    ImGui::Dummy({side, side});
    ImGui::SameLine();
    ImGui::TextUnformatted(entry.meaning.c_str());
  }
}

float legendPx(std::span<const render::LegendEntry> legend) {
  float height_px = legend.empty() ? 0 : lineGapPx();
  const float text_px = panelPx() - ImGui::GetFontSize() - ImGui::GetStyle().ItemSpacing.x;
  for (const render::LegendEntry& entry : legend)
    height_px += std::max(ImGui::GetFontSize(), textPx(entry.meaning, text_px)) + lineGapPx();
  return height_px;
}

float pickPx(const PanelContent& content) {
  float height_px = content.pick.empty() ? 0 : lineGapPx();
  for (const std::string& line : content.pick) height_px += textPx(line, panelPx()) + lineGapPx();
  return height_px;
}

void drawPick(const PanelContent& content) {
  ImGui::Separator();
  for (const std::string& line : content.pick) ImGui::TextUnformatted(line.c_str());
}

constexpr const char* kCancel = "Esc cancels";

void drawWaiting(const PanelContent& content) {
  ImGui::TextUnformatted(content.waiting.c_str());
  if (content.waiting_part >= 0) {
    bar(content.waiting_part, percentInWords(content.waiting_part), panelPx());
    ImGui::TextColored(kMuted, "%s", kCancel);
    return;
  }
  const ImVec2 size(panelPx(), ImGui::GetFontSize() * 0.5f);
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

struct Word {
  std::string text;
  ImVec4 colour;
};

/// Returns the texts at the top of the panel. Missing models, warnings and the explanation are included only
/// while the panel is visible; the other texts are always shown.
std::vector<Word> wordsOf(const PanelContent& content) {
  const Notice& notice = content.notice;
  const ImVec4& colour = notice.kind == Notice::Kind::kFailure   ? kBad
                         : notice.kind == Notice::Kind::kTrouble ? kWarning
                                                                 : kMuted;
  std::vector<Word> words{{content.title, ImGui::GetStyleColorVec4(ImGuiCol_Text)}};
  if (notice.kind != Notice::Kind::kNone) words.push_back({notice.text, colour});
  if (content.recording) words.push_back({"recording the camera path; P stops", kBad});
  if (!content.message.empty()) words.push_back({content.message, kWarning});
  if (content.visible && !content.missing.empty()) words.push_back({content.missing, kBad});
  if (content.visible && !content.warning.empty()) words.push_back({content.warning, kWarning});
  if (content.visible && !content.explanation.empty())
    words.push_back({std::string(content.show) + ": " + std::string(content.explanation), kMuted});
  return words;
}

void drawWords(const PanelContent& content) {
  for (const Word& word : wordsOf(content)) ImGui::TextColored(word.colour, "%s", word.text.c_str());
}

float wordsPx(const PanelContent& content) {
  float height_px = 0;
  for (const Word& word : wordsOf(content)) height_px += textPx(word.text, panelPx()) + lineGapPx();
  return height_px;
}

constexpr int kRankOfSharpness = -3, kRankOfPick = -2, kRankOfKeys = -1, kRankOfFrameTimes = 100;
constexpr const char* kKeys = "F1: help";

}  // namespace

/// Draws the parts of the panel that fit into the window, then the other parts, which the user can scroll to.
void Panel::drawOpen(const PanelContent& content) const {
  const float outside_px = 2 * (kPanelMarginPx + ImGui::GetStyle().WindowPadding.y);
  float room_px = ImGui::GetIO().DisplaySize.y - outside_px - wordsPx(content);
  const auto legend = legendThatFits(content.legend, legendRowPx(), room_px);
  room_px -= legendPx(legend);
  const std::vector<Figure> figures = figuresOf(content);
  std::vector<PanelPart> parts;
  for (const Figure& figure : figures) parts.push_back({figure.rank, heightOf(figure)});
  parts.push_back({kRankOfSharpness, sharpnessPx(content)});
  parts.push_back({kRankOfPick, pickPx(content)});
  parts.push_back({kRankOfKeys, content.help ? 0 : textPx(kKeys, panelPx()) + lineGapPx()});
  parts.push_back({kRankOfFrameTimes, frameTimesPx()});
  std::vector<bool> fits = partsThatFit(parts, room_px);
  drawParts(content, figures, fits, legend);
  fits.flip();
  const bool is_legend_whole = legend.size() == content.legend.size();
  drawParts(content, figures, fits,
            std::span(content.legend).subspan(is_legend_whole ? legend.size() : legend.size() - 1));
}

/// Draws some parts of the panel. @param shown  one flag per part, in the order of drawOpen(); true to draw
/// the part.
void Panel::drawParts(const PanelContent& content, std::span<const Figure> figures,
                      const std::vector<bool>& shown, std::span<const render::LegendEntry> legend) const {
  const auto rest = shown.begin() + static_cast<std::ptrdiff_t>(figures.size());
  drawFigures(figures, {shown.begin(), rest});
  if (rest[0]) drawSharpness(content);
  if (rest[3]) drawFrameTimes(frames_ms_, next_frame_, content.aimed_ms);
  drawLegend(legend);
  if (rest[1] && !content.pick.empty()) drawPick(content);
  if (rest[2] && !content.help) ImGui::TextColored(kMuted, "%s", kKeys);
}

Panel::Panel(GLFWwindow* window) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init("#version 450 core");
}

Panel::~Panel() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void Panel::prepare(double scale, const PanelContent& content) {
  bool is_new = std::exchange(scale_, static_cast<float>(scale)) != static_cast<float>(scale);
  for (const std::string* text : {&content.title, &content.waiting, &content.notice.text, &content.message,
                                  &content.missing, &content.warning})
    is_new |= characters_.add(*text);
  for (const std::string& line : content.pick) is_new |= characters_.add(line);
  for (const render::LegendEntry& entry : content.legend) is_new |= characters_.add(entry.meaning);
  if (is_new) setPanelFont(scale_, characters_);
}

void Panel::draw(const PanelContent& content) {
  frames_ms_[next_frame_] = static_cast<float>(content.frame_ms);
  next_frame_ = (next_frame_ + 1) % kFramesShown;
  ImGui_ImplOpenGL3_NewFrame();
  layOut(content);
  ImGui::EndFrame();
  layOut(content);  // lay out a second time, because ImGui knows all sizes only now
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Panel::layOut(const PanelContent& content) {
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  if (content.visible) drawMarks(content.marks, kWarning);
  ImGui::SetNextWindowPos({kPanelMarginPx, kPanelMarginPx});
  ImGui::SetNextWindowBgAlpha(0.65f);
  PanelScroll::limit();
  const bool is_waiting = !content.waiting.empty();
  if (content.visible || is_waiting || content.notice.kind != Notice::Kind::kNone || content.recording ||
      !content.message.empty()) {
    ImGui::Begin("panel", nullptr, kPlainWindow);
    ImGui::PushTextWrapPos(panelPx() + ImGui::GetStyle().WindowPadding.x);
    drawWords(content);
    if (is_waiting)
      drawWaiting(content);
    else if (content.visible && content.is_open)
      drawOpen(content);
    ImGui::PopTextWrapPos();
    scroll_.follow();
    ImGui::End();
  } else {
    scroll_.leaveOut();
  }
  covered_.reset();
  if (content.shows_settings && content.is_open) {
    Settings settings = content.settings;
    covered_ = drawSettings(kPanelMarginPx, settings);
    if (settings != content.settings) changed_ = settings;
  }
  if (content.help)
    drawHelp(content.camera, help_scroll_);
  else
    help_scroll_.leaveOut();
}

PanelScroll* Panel::scrolledAt(const glm::dvec2& place_px) {
  const ImVec2 scale = ImGui::GetIO().DisplayFramebufferScale;
  const glm::dvec2 point = place_px / glm::dvec2(scale.x, scale.y);
  for (PanelScroll* const scroll : {&help_scroll_, &scroll_})
    if (const auto& where = scroll->where(); where && where->has(point)) return scroll;
  return nullptr;
}

}  // namespace lode::app
