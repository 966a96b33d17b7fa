// SPDX-License-Identifier: Apache-2.0
#include "master/display/overlay.h"

#include <imgui/backends/imgui_impl_glfw.h>
#include <imgui/backends/imgui_impl_opengl3.h>
#include <imgui/imgui.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "common/base/isa.h"
#include "master/display/key_map.h"
#include "master/display/picture_layout.h"

namespace tessera::master {

namespace {

constexpr std::size_t kSlaveRowsMax = 12;  // fits a window of 480 pixels; the rest is summed up
constexpr std::size_t kNameShownMax = 20;
constexpr float kBarWidthPx = 80;

constexpr ImGuiWindowFlags kPanelFlags =
    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

void text(const std::string& words) { ImGui::TextUnformatted(words.c_str()); }

std::string size_text(int width_px, int height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px);
}

// How the picture's size and samples compare with what was asked for.
std::string quality(const ViewerFrame& frame) {
  const std::string size = size_text(frame.image->width_px, frame.image->height_px);
  if (!frame.is_full &&
      frame.stands_for != PixelSize{frame.image->width_px, frame.image->height_px})
    return size + " of " + size_text(frame.stands_for.width_px, frame.stands_for.height_px);
  if (!frame.is_full) return size + ", fewer samples";
  return frame.passes > 1 ? size + ", " + std::to_string(frame.passes) + " passes" : size;
}

void draw_speeds(const OverlayState& state) {
  const ViewerFrame& frame = state.frame;
  if (!frame.image) {
    text("waiting for the first frame");
    return;
  }
  const RayCounts& rays = frame.stats.rays;
  const double ray_count = static_cast<double>(rays.primary + rays.shadow + rays.secondary);
  const double seconds = frame.stats.seconds;
  ImGui::Text("%.1f frames/s   %.1f Mrays/s", state.frames_per_second,
              seconds > 0 ? ray_count / seconds * 1e-6 : 0.0);
  ImGui::Text("latency %.1f ms   frame %.1f ms", frame.latency_seconds * 1e3, seconds * 1e3);
  const std::string isa(isa_name(frame.stats.isa));
  ImGui::Text("%s   frame %llu   scene version %llu   %s%s", quality(frame).c_str(),
              static_cast<unsigned long long>(frame.stats.frame),
              static_cast<unsigned long long>(frame.stats.scene_version), isa.c_str(),
              frame.stats.is_mixed ? " (mixed)" : "");
}

void tint_square(std::uint16_t ordinal) {
  const auto c = slave_colour(ordinal);
  const float edge = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::GetWindowDrawList()->AddRectFilled(
      at, ImVec2(at.x + edge, at.y + edge),
      ImGui::ColorConvertFloat4ToU32(ImVec4(c[0], c[1], c[2], 1)));
  ImGui::Dummy(ImVec2(edge, edge));
  ImGui::SameLine();
}

// Green where every thread is at work, red where they wait.
void utilisation_bar(double share) {
  const auto full = static_cast<float>(std::clamp(share, 0.0, 1.0));
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram,
                        ImVec4(0.75f - 0.55f * full, 0.2f + 0.4f * full, 0.2f, 1));
  char percent[16];
  std::snprintf(percent, sizeof(percent), "%.0f %%", 100 * full);
  ImGui::ProgressBar(full, ImVec2(kBarWidthPx, ImGui::GetTextLineHeight()), percent);
  ImGui::PopStyleColor();
}

// A long name keeps both ends: slaves are often told apart by a number at the end.
std::string shortened(const std::string& name) {
  if (name.size() <= kNameShownMax) return name;
  const std::size_t kept = kNameShownMax / 2 - 1;
  return name.substr(0, kept) + ".." + name.substr(name.size() - kept);
}

void draw_slave_row(const SlaveStatus& slave, bool tints_tiles) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  if (tints_tiles) tint_square(slave.ordinal);
  text(shortened(slave.name));
  ImGui::TableNextColumn();
  if (slave.state == SlaveState::kReady) {
    utilisation_bar(slave.utilisation);
  } else {
    text(slave.state == SlaveState::kStalled ? "stalled" : "scene");
  }
  ImGui::TableNextColumn();
  ImGui::Text("%u %s", slave.threads, std::string(isa_name(slave.isa)).c_str());
  ImGui::TableNextColumn();
  ImGui::Text("%.0f", slave.tiles_per_second);
  ImGui::TableNextColumn();
  ImGui::Text("%u", slave.prefetch_depth);
  ImGui::TableNextColumn();
  ImGui::Text("%.2f ms", slave.rtt_seconds * 1e3);
}

// Sums up the slaves whose rows are not shown.
void draw_others(const std::vector<SlaveStatus>& slaves) {
  double busy = 0;
  for (std::size_t i = kSlaveRowsMax; i < slaves.size(); ++i) busy += slaves[i].utilisation;
  const std::size_t count = slaves.size() - kSlaveRowsMax;
  ImGui::Text("and %zu more, %.0f %% busy", count, 100 * busy / static_cast<double>(count));
}

void draw_slaves(const OverlayState& state) {
  if (!state.cluster) return text("asking for slaves");
  const std::vector<SlaveStatus>& slaves = state.cluster->slaves;
  if (slaves.empty()) return text("no slave: waiting");
  if (!state.shows_slaves) {
    ImGui::Text("%zu slaves (l lists them)", slaves.size());
    return;
  }
  constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_SizingFixedFit |
                                     ImGuiTableFlags_BordersInnerV | ImGuiTableFlags_NoHostExtendX;
  if (ImGui::BeginTable("slaves", 6, kFlags)) {
    for (const char* title : {"slave", "busy", "threads", "tiles/s", "ahead", "rtt"}) {
      ImGui::TableSetupColumn(title);
    }
    ImGui::TableHeadersRow();
    for (std::size_t i = 0; i < slaves.size() && i < kSlaveRowsMax; ++i)
      draw_slave_row(slaves[i], state.tints_tiles);
    ImGui::EndTable();
  }
  if (slaves.size() > kSlaveRowsMax) draw_others(slaves);
}

void draw_panel(OverlayState& state) {
  ImGui::SetNextWindowPos(ImVec2(10, 10), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowBgAlpha(0.75f);
  if (ImGui::Begin("tessera", nullptr, kPanelFlags)) {
    draw_speeds(state);
    ImGui::Separator();
    draw_slaves(state);
    ImGui::Separator();
    ImGui::Checkbox("tint tiles by slave (t)", &state.tints_tiles);
    ImGui::SameLine();
    ImGui::Checkbox("slaves (l)", &state.shows_slaves);
    ImGui::SameLine();
    ImGui::Checkbox("help (h)", &state.shows_help);
  }
  ImGui::End();
}

void draw_help() {
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x - 10, io.DisplaySize.y - 10), ImGuiCond_Always,
                          ImVec2(1, 1));
  ImGui::SetNextWindowBgAlpha(0.85f);
  if (ImGui::Begin("help", nullptr, kPanelFlags | ImGuiWindowFlags_NoMove)) {
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
      for (const KeyBinding& binding : key_bindings()) {
        ImGui::TableNextColumn();
        text(std::string(binding.label));
        ImGui::TableNextColumn();
        text(std::string(binding.meaning));
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
}

void draw_notice(const std::string& line) {
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos(ImVec2(10, io.DisplaySize.y - 10), ImGuiCond_Always, ImVec2(0, 1));
  ImGui::SetNextWindowBgAlpha(0.85f);
  if (ImGui::Begin("notice", nullptr,
                   kPanelFlags | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoTitleBar |
                       ImGuiWindowFlags_NoInputs)) {
    ImGui::PushTextWrapPos(io.DisplaySize.x - 40);
    text(line);
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

}  // namespace

Overlay::Overlay(GLFWwindow* window) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // no file is written into the current folder
  ImGui::StyleColorsDark();
  ImGui::GetStyle().WindowRounding = 4;
  is_ready_ =
      ImGui_ImplGlfw_InitForOpenGL(window, true) && ImGui_ImplOpenGL3_Init("#version 330 core");
}

Overlay::~Overlay() {
  if (is_ready_) {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
  }
  ImGui::DestroyContext();
}

void Overlay::draw(OverlayState& state) {
  if (!is_ready_) return;
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  if (state.shows_overlay) draw_panel(state);
  if (state.shows_help) draw_help();
  if (!state.notice.empty()) draw_notice(state.notice);
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

bool Overlay::is_mouse_over() const { return ImGui::GetIO().WantCaptureMouse; }

}  // namespace tessera::master
