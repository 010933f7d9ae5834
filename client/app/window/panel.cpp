#include "client/app/window/panel.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "client/app/window/key_help.h"
#include "client/app/window/panel_font.h"
#include "client/app/window/sharpness.h"
#include "common/byte_size.h"

namespace lode::app {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                                    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs;
constexpr float kMarginPx = 12;
constexpr float kPanelEm = 23.5f, kNameEm = 5.5f, kKeysEm = 6.5f;  ///< widths, in sizes of a letter
const ImVec4 kMuted(0.62f, 0.66f, 0.72f, 1), kGood(0.55f, 0.85f, 0.60f, 1), kWarning(1.0f, 0.72f, 0.40f, 1),
    kBad(1.0f, 0.50f, 0.45f, 1), kBar(0.26f, 0.48f, 0.72f, 1);

/// What a window leaves of a width, between its own sides and the panel's.
float fitting(float width_px) {
  const float sides_px = 2 * (kMarginPx + ImGui::GetStyle().WindowPadding.x);
  return std::clamp(width_px, 1.0f, std::max(1.0f, ImGui::GetIO().DisplaySize.x - sides_px));
}

float panelPx() { return fitting(ImGui::GetFontSize() * kPanelEm); }
float namePx() { return std::min(ImGui::GetFontSize() * kNameEm, panelPx() / 2); }
float valuePx() { return panelPx() - namePx(); }

std::string countOf(uint64_t value) {
  std::string digits = std::to_string(value);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<size_t>(at), " ");
  }
  return digits;
}

std::string nameOf(CameraKind camera) {
  switch (camera) {
    case CameraKind::kFly:
      return "fly: W A S D";
    case CameraKind::kWalk:
      return "walk: W A S D";
    case CameraKind::kOrbit:
      break;
  }
  return "orbit";
}

void nameRow(const char* name) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(kMuted, "%s", name);
  ImGui::TableNextColumn();
}

void row(const char* name, const std::string& value) {
  nameRow(name);
  ImGui::TextUnformatted(value.c_str());
}

std::string formatted(const char* format, double a, double b = 0) {
  char text[64];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// A bar with its figures on it.
void bar(double part, const std::string& text, float width_px) {
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, kBar);
  ImGui::ProgressBar(static_cast<float>(part), {width_px, 0}, text.c_str());
  ImGui::PopStyleColor();
}

void memoryRow(const char* name, uint64_t bytes, uint64_t budget_bytes) {
  nameRow(name);
  const double part = static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(1, budget_bytes));
  bar(part, describeBytes(bytes) + " of " + describeBytes(budget_bytes), valuePx());
}

std::string networkOf(const PanelContent& content) {
  std::string text = describeBytes(content.received_bytes);
  if (content.link_bytes_per_s > 0)
    text += ", " + describeBytes(static_cast<uint64_t>(content.link_bytes_per_s)) + "/s";
  if (content.round_trip_ms > 0) text += formatted(", %.1f ms", content.round_trip_ms);
  if (content.open_wishes > 0) text += ", " + countOf(content.open_wishes) + " wishes";
  return text;
}

std::string tilesOf(const PanelContent& content) {
  const std::string tiles = countOf(content.tiles) + " tiles";
  return content.tiles_left_out == 0 ? tiles : tiles + ", no room for " + countOf(content.tiles_left_out);
}

void drawFigures(const PanelContent& content) {
  if (!ImGui::BeginTable("figures", 2, ImGuiTableFlags_SizingFixedFit)) return;
  // Widths that do not follow the figures: the panel would lag a frame behind them.
  ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthFixed, namePx());
  ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthFixed, valuePx());
  row("triangles", countOf(content.triangles) + " of " + countOf(content.model_triangles));
  row("nodes", countOf(content.nodes));
  row("network", networkOf(content));
  memoryRow("memory", content.resident_bytes, content.resident_budget_bytes);
  memoryRow("on the GPU", content.gpu_bytes, content.gpu_budget_bytes);
  if (content.textured) row("textures", tilesOf(content));
  row("threshold", formatted("%.2f px", content.threshold_px));
  if (content.target_ms > 0) row("", formatted("coarser for %.0f frames a second", 1000 / content.target_ms));
  row("view", std::string(content.show));
  row("camera", nameOf(content.camera));
  row("frame", formatted("%.1f ms, upload %.1f ms", content.frame_ms, content.upload_ms));
  ImGui::EndTable();
  if (!content.lost.empty())
    ImGui::TextColored(kWarning, "%s", content.lost.data());
  else if (content.converged)
    ImGui::TextColored(kGood, "%s", convergedText(content.error_px, content.threshold_px).c_str());
  else if (content.limited)
    ImGui::TextUnformatted(limitedText(content.error_px).c_str());
  else if (!content.exhausted)
    bar(content.progress, refiningText(content.error_px), panelPx());
}

void drawFrameTimes(std::span<const float> frames_ms, size_t oldest) {
  const float most_ms = std::max(1.0f, *std::ranges::max_element(frames_ms));
  ImGui::TextColored(kMuted, "frame times, up to %.0f ms", static_cast<double>(most_ms));
  ImGui::PlotHistogram("##frames", frames_ms.data(), static_cast<int>(frames_ms.size()),
                       static_cast<int>(oldest), nullptr, 0, most_ms,
                       {panelPx(), ImGui::GetFontSize() * 2.5f});
}

void drawLegend(const PanelContent& content) {
  ImGui::Separator();
  for (const render::LegendEntry& entry : content.legend) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float side = ImGui::GetFontSize();
    ImGui::GetWindowDrawList()->AddRectFilled(
        at, {at.x + side, at.y + side}, IM_COL32(entry.colour.r, entry.colour.g, entry.colour.b, 255), 2);
    ImGui::Dummy({side, side});
    ImGui::SameLine();
    ImGui::TextUnformatted(entry.meaning.c_str());
  }
}

void drawPick(const PanelContent& content) {
  ImGui::Separator();
  for (const std::string& line : content.pick) ImGui::TextUnformatted(line.c_str());
}

/// Over the picture and below the panel; a dark rim keeps them legible on every model.
void drawMarks(const PickMarks& marks) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImU32 light = ImGui::GetColorU32(kWarning), dark = IM_COL32(0, 0, 0, 200);
  const float em = ImGui::GetFontSize();
  const ImVec2 unit_px = ImGui::GetIO().DisplayFramebufferScale;
  const auto placeOf = [&](const glm::dvec2& px) {
    return ImVec2(static_cast<float>(px.x) / unit_px.x, static_cast<float>(px.y) / unit_px.y);
  };
  if (marks.line) {
    const ImVec2 from = placeOf(marks.line->from_px), to = placeOf(marks.line->to_px);
    list->AddLine(from, to, dark, em / 4);
    list->AddLine(from, to, light, em / 10);
    const ImVec2 text = ImGui::CalcTextSize(marks.distance.c_str());
    const ImVec2 at((from.x + to.x - text.x) / 2, (from.y + to.y) / 2 + em / 2);
    list->AddRectFilled({at.x - em / 4, at.y}, {at.x + text.x + em / 4, at.y + text.y}, dark, em / 4);
    list->AddText(at, light, marks.distance.c_str());
  }
  for (const glm::dvec2& point_px : marks.points_px) {
    list->AddCircleFilled(placeOf(point_px), em / 3, dark);
    list->AddCircleFilled(placeOf(point_px), em / 5, light);
  }
}

void drawWaiting(const PanelContent& content) {
  ImGui::TextUnformatted(content.waiting.c_str());
  if (content.waiting_part >= 0) {
    bar(content.waiting_part, formatted("%.0f %%", 100 * content.waiting_part), panelPx());
    return;
  }
  const ImVec2 size(fitting(ImGui::GetFontSize() * 18), ImGui::GetFontSize() * 0.5f);
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
  ImGui::TextColored(kMuted, "%.0f s", content.waited_s);
}

void drawNotice(const Notice& notice) {
  const ImVec4& colour = notice.kind == Notice::Kind::kFailure   ? kBad
                         : notice.kind == Notice::Kind::kTrouble ? kWarning
                                                                 : kMuted;
  ImGui::TextColored(colour, "%s", notice.text.c_str());
}

float widthOf(std::span<const KeyHelp> keys) {
  float width_px = 0;
  for (const KeyHelp& key : keys) width_px = std::max(width_px, ImGui::CalcTextSize(key.what.data()).x);
  return width_px;
}

void drawKeys(std::span<const KeyHelp> keys) {
  for (const KeyHelp& key : keys) row(key.keys.data(), std::string(key.what));
}

/// In the middle of the picture.
void drawHelp(const PanelContent& content) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.9f);
  ImGui::Begin("help", nullptr, kPlain);
  const float keys_px = ImGui::GetFontSize() * kKeysEm;
  const float what_px = std::max(widthOf(cameraHelp(content.camera)), widthOf(commonHelp()));
  ImGui::PushTextWrapPos(0);  // where a column or the window ends
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
    ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, keys_px);
    ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthFixed, fitting(keys_px + what_px) - keys_px);
    drawKeys(cameraHelp(content.camera));
    drawKeys(commonHelp());
    ImGui::EndTable();
  }
  ImGui::TextColored(kMuted, "any key closes this, F1 or ? opens it");
  ImGui::PopTextWrapPos();
  ImGui::End();
}

}  // namespace

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

bool Panel::wantsMouse() const { return ImGui::GetIO().WantCaptureMouse; }
bool Panel::wantsKeyboard() const { return ImGui::GetIO().WantCaptureKeyboard; }

void Panel::setScale(double scale) {
  if (scale_ == static_cast<float>(scale)) return;
  scale_ = static_cast<float>(scale);
  setPanelScale(scale_);
}

void Panel::draw(const PanelContent& content) {
  frames_ms_[next_frame_] = static_cast<float>(content.frame_ms);
  next_frame_ = (next_frame_ + 1) % kFramesShown;
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  if (content.visible) drawMarks(content.marks);
  ImGui::SetNextWindowPos({kMarginPx, kMarginPx});
  ImGui::SetNextWindowBgAlpha(0.65f);
  const bool is_waiting = !content.waiting.empty(), has_notice = content.notice.kind != Notice::Kind::kNone;
  if (content.visible || is_waiting || has_notice || content.recording || !content.message.empty()) {
    ImGui::Begin("panel", nullptr, kPlain);
    ImGui::PushTextWrapPos(panelPx() + ImGui::GetFontSize());
    ImGui::TextUnformatted(content.title.c_str());
    if (is_waiting) {
      drawWaiting(content);
    } else if (content.visible && content.is_open) {
      drawFigures(content);
      drawFrameTimes(frames_ms_, next_frame_);
      if (!content.legend.empty()) drawLegend(content);
      if (!content.pick.empty()) drawPick(content);
    }
    if (has_notice) drawNotice(content.notice);
    if (content.recording) ImGui::TextColored(kBad, "recording the camera; P ends it");
    if (!content.message.empty()) ImGui::TextColored(kWarning, "%s", content.message.c_str());
    if (content.visible && !content.help) ImGui::TextColored(kMuted, "F1: what keys do");
    ImGui::PopTextWrapPos();
    ImGui::End();
  }
  if (content.help) drawHelp(content);
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace lode::app
