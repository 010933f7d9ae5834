#include "client/app/window/panel.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

namespace lode::app {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                                    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs;
constexpr float kMarginPx = 12;
const ImVec4 kMuted(0.62f, 0.66f, 0.72f, 1), kGood(0.55f, 0.85f, 0.60f, 1), kWarning(1.0f, 0.72f, 0.40f, 1);

std::string countOf(uint64_t value) {
  std::string digits = std::to_string(value);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<size_t>(at), " ");
  }
  return digits;
}

std::string bytesOf(uint64_t bytes) {
  char text[32];
  const double size = static_cast<double>(bytes);
  if (size < 1e6) {
    std::snprintf(text, sizeof text, "%.1f kB", size / 1e3);
  } else {
    std::snprintf(text, sizeof text, size < 1e9 ? "%.1f MB" : "%.2f GB", size / (size < 1e9 ? 1e6 : 1e9));
  }
  return text;
}

void row(const char* name, const std::string& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(kMuted, "%s", name);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(value.c_str());
}

std::string formatted(const char* format, double a, double b = 0) {
  char text[64];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

std::string tilesOf(const PanelContent& content) {
  const std::string tiles = countOf(content.tiles) + " tiles";
  return content.tiles_left_out == 0 ? tiles : tiles + ", no room for " + countOf(content.tiles_left_out);
}

void drawFigures(const PanelContent& content) {
  if (!ImGui::BeginTable("figures", 2, ImGuiTableFlags_SizingFixedFit)) return;
  // Widths that do not follow the figures: the panel would lag a frame behind them.
  ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthFixed, ImGui::GetFontSize() * 5.5f);
  ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthFixed, ImGui::GetFontSize() * 18);
  row("triangles", countOf(content.triangles) + " of " + countOf(content.model_triangles));
  row("nodes", countOf(content.nodes));
  row("received", bytesOf(content.received_bytes));
  row("memory", bytesOf(content.resident_bytes) + ", GPU " + bytesOf(content.gpu_bytes));
  if (content.textured) row("textures", tilesOf(content));
  row("threshold", formatted("%.2f px, error %.2f px", content.threshold_px, content.error_px));
  if (content.target_ms > 0) row("", formatted("coarser for %.0f frames a second", 1000 / content.target_ms));
  row("view", std::string(content.show));
  row("frame", formatted("%.1f ms, upload %.1f ms", content.frame_ms, content.upload_ms));
  ImGui::EndTable();
  if (content.converged) {
    const bool is_fine = content.error_px <= content.threshold_px;
    ImGui::TextColored(kGood, "%s, at most %.2f px off where it is seen",
                       is_fine ? "converged" : "all the detail there is",
                       static_cast<double>(content.error_px));
  } else {
    ImGui::TextColored(kWarning, "refining");
  }
}

void drawFrameTimes(std::span<const float> frames_ms, size_t oldest) {
  const float most_ms = std::max(1.0f, *std::ranges::max_element(frames_ms));
  ImGui::TextColored(kMuted, "frame times, up to %.0f ms", static_cast<double>(most_ms));
  ImGui::PlotHistogram("##frames", frames_ms.data(), static_cast<int>(frames_ms.size()),
                       static_cast<int>(oldest), nullptr, 0, most_ms,
                       {ImGui::GetFontSize() * 23.5f, ImGui::GetFontSize() * 2.5f});
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

void drawWaiting(const PanelContent& content) {
  ImGui::TextUnformatted(content.waiting.c_str());
  const ImVec2 size(ImGui::GetFontSize() * 18, ImGui::GetFontSize() * 0.5f);
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

void drawHelp(bool flying) {
  ImGui::Separator();
  const char* const camera = flying ? "W A S D move, Q E down and up, Shift fast\n"
                                      "drag to look, wheel for the speed\n"
                                      "Tab orbit"
                                    : "drag to turn, right drag to shift, wheel to zoom\n"
                                      "click to measure, double click to go there\n"
                                      "Tab fly";
  ImGui::TextColored(kMuted, "%s", camera);
  ImGui::TextColored(kMuted,
                     "R reset   U up axis   + - threshold\n"
                     "V views   F wireframe   H this panel\n"
                     "C copy what was clicked   P record camera\n"
                     "1 to 9 go to a bookmark, Ctrl 1 to 9 set it\n"
                     "F12 screenshot   Esc quit");
}

}  // namespace

Panel::Panel(GLFWwindow* window, double scale) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  ImFontConfig font;
  font.SizePixels = std::round(13.0f * static_cast<float>(scale));
  io.Fonts->AddFontDefault(&font);
  ImGui::StyleColorsDark();
  ImGui::GetStyle().WindowRounding = 5;
  ImGui::GetStyle().WindowBorderSize = 0;
  ImGui::GetStyle().ScaleAllSizes(static_cast<float>(scale));
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

void Panel::draw(const PanelContent& content) {
  frames_ms_[next_frame_] = static_cast<float>(content.frame_ms);
  next_frame_ = (next_frame_ + 1) % kFramesShown;
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  ImGui::SetNextWindowPos({kMarginPx, kMarginPx});
  ImGui::SetNextWindowBgAlpha(0.65f);
  const bool shown = content.visible || !content.waiting.empty() || !content.message.empty();
  if (shown) {
    ImGui::Begin("panel", nullptr, kPlain);
    ImGui::TextUnformatted(content.title.c_str());
    if (!content.waiting.empty()) {
      drawWaiting(content);
    } else if (content.visible) {
      drawFigures(content);
      drawFrameTimes(frames_ms_, next_frame_);
      if (!content.legend.empty()) drawLegend(content);
      if (!content.pick.empty()) drawPick(content);
    }
    if (!content.message.empty()) {
      ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26);
      ImGui::TextColored(kWarning, "%s", content.message.c_str());
      ImGui::PopTextWrapPos();
    }
    if (content.visible && content.waiting.empty()) drawHelp(content.flying);
    ImGui::End();
  }
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace lode::app
