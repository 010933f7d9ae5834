#include "client/app/window/panel/panel.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "client/app/window/panel/panel_figures.h"
#include "client/app/window/panel/panel_font.h"
#include "client/app/window/panel/panel_help.h"
#include "client/app/window/panel/panel_layout.h"
#include "client/app/window/panel/panel_window.h"
#include "client/app/window/panel/panel_words.h"
#include "client/app/window/panel/pick_marks.h"
#include "client/app/window/panel/sharpness.h"

namespace lode::app {
namespace {

constexpr float kNameEm = 5.5f;  ///< width of the column of names, in multiples of the font size
constexpr float kPanelAlpha = 0.65f, kHelpAlpha = 0.9f;

float panelPx() { return fittingPx(panelWidthPx(ImGui::GetIO().DisplaySize.x, ImGui::GetFontSize())); }
float namePx() { return std::min(ImGui::GetFontSize() * kNameEm, panelPx() / 2); }
float valuePx() { return panelPx() - namePx(); }

float lineGapPx() { return ImGui::GetStyle().ItemSpacing.y; }

float heightOf(const Figure& figure) {
  const float name_px = textPx(figure.name, namePx());
  const float value_px = figure.part >= 0 ? barPx(figure.value, valuePx()) : textPx(figure.value, valuePx());
  return std::max(name_px, value_px) + 2 * ImGui::GetStyle().CellPadding.y;
}

void drawFigures(std::span<const Figure> figures, const std::vector<bool>& shown) {
  if (std::ranges::find(shown, true) == shown.end() ||
      !ImGui::BeginTable("figures", 2, ImGuiTableFlags_SizingFixedFit,
                         {panelPx() + 2 * ImGui::GetStyle().CellPadding.x, 0}))
    return;
  // Fix the column widths, because widths that follow the contents would lag one frame behind.
  ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthFixed, namePx());
  ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthFixed, valuePx());
  ImGui::PushTextWrapPos(0);  // wraps at the end of the column
  for (size_t i = 0; i < figures.size(); ++i) {
    if (!shown[i]) continue;
    nameRow(figures[i].name);
    if (figures[i].part >= 0)
      drawBar(figures[i].part, figures[i].value, valuePx());
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
  if (isRefining(content)) return drawBar(content.progress, text, panelPx());
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

constexpr int kRankOfSharpness = -3, kRankOfPick = -2, kRankOfKeys = -1, kRankOfFrameTimes = 100;
constexpr const char* kKeys = "F1: help";

/// Returns true if the panel is visible or has something to say although it is hidden.
bool hasPanel(const PanelContent& content) {
  return content.visible || !content.waiting.empty() || content.notice.kind != Notice::Kind::kNone ||
         content.recording || !content.message.empty();
}

// ImDrawData has an array of lists up to ImGui 1.89.7, and a vector since then.
[[maybe_unused]] void setLists(ImDrawList**& of_data, std::vector<ImDrawList*>& lists) {
  of_data = lists.data();
}
[[maybe_unused]] void setLists(ImVector<ImDrawList*>& of_data, const std::vector<ImDrawList*>& lists) {
  of_data.resize(static_cast<int>(lists.size()));
  std::copy(lists.begin(), lists.end(), of_data.begin());
}

}  // namespace

/// Draws the parts of the panel that fit into the window, then the other parts, which the user can scroll to.
void Panel::drawOpen(const PanelContent& content) const {
  const float outside_px = 2 * (kPanelMarginPx + ImGui::GetStyle().WindowPadding.y);
  float room_px = ImGui::GetIO().DisplaySize.y - outside_px - wordsPx(content, panelPx());
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
  ImGui::GetIO().ConfigInputTextCursorBlink = false;  // the window draws only after input
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
                                  &content.missing, &content.warning, &content.hidden})
    is_new |= characters_.add(*text);
  for (const std::string& line : content.pick) is_new |= characters_.add(line);
  if (content.start) {
    is_new |= characters_.add(path_.data());
    is_new |= characters_.add(content.start->message);
    for (const OfferedTarget& one : content.start->recent) is_new |= characters_.add(one.target);
  }
  for (const render::LegendEntry& entry : content.legend) is_new |= characters_.add(entry.meaning);
  if (is_new) setPanelFont(scale_, characters_);
}

void Panel::drawMarksOf(const PanelContent& content) {
  frames_ms_[next_frame_] = static_cast<float>(content.frame_ms);
  next_frame_ = (next_frame_ + 1) % kFramesShown;
  ImGui_ImplOpenGL3_NewFrame();
  layOut(content);
  ImGui::EndFrame();
  layOut(content);  // lay out a second time, because ImGui knows all sizes only now
  ImGui::Render();
  drawLists(true);
}

/// Draws the marks of the last layout, or everything else. ImGui keeps the marks in the draw list of the
/// background.
void Panel::drawLists(bool marks) {
  ImDrawData data = *ImGui::GetDrawData();
  const ImDrawList* const background = ImGui::GetBackgroundDrawList();
  std::vector<ImDrawList*> lists;
  for (int i = 0; i < data.CmdListsCount; ++i)
    if ((data.CmdLists[i] == background) == marks) lists.push_back(data.CmdLists[i]);
  setLists(data.CmdLists, lists);
  data.CmdListsCount = static_cast<int>(lists.size());
  ImGui_ImplOpenGL3_RenderDrawData(&data);
}

/// Lays out the panel or the help at the left and the settings at the right. If the window is too narrow for
/// both, leaves out the settings while the help is open, and the panel otherwise.
void Panel::layOut(const PanelContent& content) {
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  if (content.start) return layOutStart(*content.start);
  if (content.visible && content.scale_marks) drawScale(*content.scale_marks);
  for (const PickMarks& marks : content.marks)
    if (content.visible) drawMarks(marks, kWarning);
  const bool shows_settings = content.shows_settings && content.is_open;
  const float left_px = content.help ? helpWidthPx(content.camera) : panelPx();
  const float left_outside_px =
      left_px + 2 * (ImGui::GetStyle().WindowPadding.x + ImGui::GetStyle().CellPadding.x);
  const bool both_fit = fitSideBySide(left_outside_px, settingsWidthPx(kPanelMarginPx), kPanelMarginPx,
                                      ImGui::GetIO().DisplaySize.x);
  const bool is_left_free = both_fit || !shows_settings || content.help;
  PanelScroll& scroll = content.help ? help_scroll_ : scroll_;
  (content.help ? scroll_ : help_scroll_).leaveOut();
  if (is_left_free && (content.help || hasPanel(content)))
    drawLeft(content, left_px, scroll);
  else
    scroll.leaveOut();
  covered_.reset();
  if (!shows_settings || (content.help && !both_fit)) return;
  Settings settings = content.settings;
  covered_ = drawSettings(kPanelMarginPx, settings);
  if (settings != content.settings) changed_ = settings;
}

/// Lays out the start page, which is alone in the window.
void Panel::layOutStart(const StartPage& page) {
  for (PanelScroll* const scroll : {&help_scroll_, &scroll_}) scroll->leaveOut();
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  covered_ = Covered{{0, 0}, {display.x, display.y}};
  if (std::string chosen = drawStartPage(page, path_); !chosen.empty()) chosen_ = std::move(chosen);
}

/// Draws the panel, or the help in its place: the title and notices are at the top of both.
void Panel::drawLeft(const PanelContent& content, float width_px, PanelScroll& scroll) const {
  ImGui::SetNextWindowPos({kPanelMarginPx, kPanelMarginPx});
  ImGui::SetNextWindowBgAlpha(content.help ? kHelpAlpha : kPanelAlpha);
  PanelScroll::limit();
  ImGui::Begin(content.help ? "help" : "panel", nullptr, kPlainWindow);
  ImGui::PushTextWrapPos(width_px + ImGui::GetStyle().WindowPadding.x);
  drawWords(content, width_px);
  if (!content.waiting.empty())
    drawWaiting(content, width_px);
  else if (content.visible && content.is_open && !content.help)
    drawOpen(content);
  if (content.help) drawHelp(content.camera, width_px);
  ImGui::PopTextWrapPos();
  scroll.follow();
  ImGui::End();
}

PanelScroll* Panel::scrolledAt(const glm::dvec2& place_px) {
  const ImVec2 scale = ImGui::GetIO().DisplayFramebufferScale;
  const glm::dvec2 point = place_px / glm::dvec2(scale.x, scale.y);
  for (PanelScroll* const scroll : {&help_scroll_, &scroll_})
    if (const auto& where = scroll->where(); where && where->has(point)) return scroll;
  return nullptr;
}

}  // namespace lode::app
