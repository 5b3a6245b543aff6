// SPDX-License-Identifier: Apache-2.0
#include "client/window/panels.h"

#include <algorithm>
#include <array>

#include <imgui.h>

#include "client/view/look_keys.h"

namespace seaway::client {

namespace {

constexpr ImU32 warning_colour = IM_COL32(255, 190, 80, 255);
constexpr float width_letters = 46, curve_lines = 5;
constexpr std::size_t path_bytes_max = 1024;

void table(const char* name, const std::vector<PanelRow>& rows) {
    if (!ImGui::BeginTable(name, 2))
        return;
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed);
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
    for (const PanelRow& row : rows) {
        ImGui::TableNextColumn();
        ImGui::TextDisabled("%s", row.label.c_str());
        ImGui::TableNextColumn();
        ImGui::TextWrapped("%s", row.value.c_str());
    }
    ImGui::EndTable();
}

/// A slider of doubles.
bool slide(const char* name, double& value, double least, double most, const char* format,
           ImGuiSliderFlags flags = 0) {
    return ImGui::SliderScalar(name, ImGuiDataType_Double, &value, &least, &most, format,
                               flags | ImGuiSliderFlags_AlwaysClamp);
}

void overlay(const WindowModel& model) {
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    if (!model.notice.empty()) {
        const ImVec2 text = ImGui::CalcTextSize(model.notice.c_str());
        const ImVec2 at((size.x - text.x) / 2, size.y / 12);
        draw.AddRectFilled({at.x - 12, at.y - 8}, {at.x + text.x + 12, at.y + text.y + 8},
                           IM_COL32(20, 20, 20, 200), 4);
        draw.AddText(at, warning_colour, model.notice.c_str());
    }
    const glm::dvec2 scale(static_cast<double>(size.x) / model.legend_pixels.x,
                           static_cast<double>(size.y) / model.legend_pixels.y);
    for (const LegendBox& box : model.legend.boxes) {
        const auto at = [&](int x, int y) {
            return ImVec2(static_cast<float>(x * scale.x), static_cast<float>(y * scale.y));
        };
        const glm::vec4 colour(box.colour, box.opacity);
        draw.AddRectFilled(
            at(box.left, box.top), at(box.left + box.width, box.top + box.height),
            ImGui::ColorConvertFloat4ToU32({colour.r, colour.g, colour.b, colour.a}));
    }
    if (model.probe_mark) {
        const ImVec2 at(static_cast<float>((model.probe_mark->x + 1) / 2) * size.x,
                        static_cast<float>((model.probe_mark->y + 1) / 2) * size.y);
        draw.AddCircle(at, 8.5f, IM_COL32(0, 0, 0, 230), 0, 1.5f);
        draw.AddCircle(at, 7, IM_COL32(255, 255, 255, 230), 0, 2);
        draw.AddCircleFilled(at, 2, IM_COL32(255, 60, 40, 255));
    }
}

} // namespace

void Panels::note(const char* name) {
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    places_[name] = {{low.x, low.y}, {high.x, high.y}};
}

void Panels::plot(const char* name, const Curve& curve) {
    if (!curve.values.empty()) {
        // Unlike most of ImGui, a plot does not take a negative width for what is left.
        const ImVec2 size(ImGui::GetContentRegionAvail().x,
                          curve_lines * ImGui::GetTextLineHeight());
        ImGui::PlotLines((std::string("##") + name).c_str(), curve.values.data(),
                         static_cast<int>(curve.values.size()), 0, nullptr, curve.least, curve.most,
                         size);
        note(name);
    }
    if (!curve.caption.empty())
        ImGui::TextWrapped("%s", curve.caption.c_str());
}

bool Panels::header(const char* name, bool open) {
    const bool shown = ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
    note(name);
    return shown;
}

void Panels::light(const WindowModel& model, ViewChoice& choice) {
    Look& look = choice.look;
    const bool picture = !look.environment.empty(); // which has its own sun and clouds
    if (picture) {
        ImGui::TextWrapped("sky of %s", look.environment.c_str());
        if (ImGui::Button("computed sky")) {
            look.environment.clear();
            look.environment_turn_deg = 0;
        }
        note("computed sky");
    } else if (look.place) {
        ImGui::TextWrapped("%s at %.2f, %.2f", to_text(look.place->when).c_str(),
                           look.place->latitude_deg, look.place->longitude_deg);
        if (ImGui::Button("by the hour"))
            look.place.reset();
        note("by the hour");
    } else {
        slide("time of day", look.hour, hours.lo, hours.hi, "%.2f h");
        note("hour");
    }
    slide("visibility", look.air.visibility_m, visibility_min_m, visibility_max_m, "%.0f m",
          ImGuiSliderFlags_Logarithmic);
    note("visibility");
    if (!picture) {
        slide("clouds", look.clouds.coverage, cloud_shares.lo, cloud_shares.hi, "%.2f");
        note("clouds");
    }
    const auto name = [](sea::WaterType type) { return std::string(sea::name_of(type)); };
    const std::string of_sea = name(model.water_of_sea) + ", of the sea";
    if (ImGui::BeginCombo("water", look.water ? name(*look.water).c_str() : of_sea.c_str())) {
        if (ImGui::Selectable(of_sea.c_str(), !look.water))
            look.water.reset();
        for (const auto& [word, type] : sea::water_types)
            if (ImGui::Selectable(word.data(), look.water == type))
                look.water = type;
        ImGui::EndCombo();
    }
    note("water");
}

void Panels::look_file(const WindowModel& model, ViewChoice& choice, Asked& asked) {
    std::array<char, path_bytes_max> path{};
    choice.look_path.copy(path.data(), path.size() - 1);
    if (ImGui::InputText("file", path.data(), path.size()))
        choice.look_path = path.data();
    note("look path");
    asked.load_look = ImGui::Button("load");
    note("load look");
    ImGui::SameLine();
    asked.save_look = ImGui::Button("save");
    note("save look");
    if (!model.look_said.empty())
        ImGui::TextWrapped("%s", model.look_said.c_str());
}

void Panels::view(const WindowModel& model, ViewChoice& choice) {
    light(model, choice);
    slide("exposure", choice.look.exposure_stops, exposure_stops.lo, exposure_stops.hi, "%+.2f EV");
    note("exposure");
    if (ImGui::BeginCombo("quality", quality_table[choice.quality].name.data())) {
        for (std::size_t i = 0; i < quality_table.size(); ++i) {
            if (ImGui::Selectable(quality_table[i].name.data(), i == choice.quality))
                choice.quality = i;
            note(quality_table[i].name.data());
            if (ImGui::IsItemHovered())
                ImGui::SetTooltip("%s", quality_table[i].meaning.data());
        }
        ImGui::EndCombo();
    }
    note("quality");
    debug(model, choice.debug);
}

void Panels::debug(const WindowModel& model, DebugChoice& choice) {
    if (ImGui::BeginCombo("show", info(choice.view).name.data())) {
        for (const DebugViewInfo& row : debug_view_table()) {
            if (ImGui::Selectable(row.name.data(), row.view == choice.view))
                choice = {.view = row.view, .legend = choice.legend};
            if (ImGui::IsItemHovered())
                ImGui::SetTooltip("%s", row.meaning.data());
        }
        ImGui::EndCombo();
    }
    note("show");
    const DebugViewInfo& row = info(choice.view);
    if (row.source == DebugSource::light)
        return;
    if (row.takes(DebugKey::cascade)) {
        const bool all = row.cascades == DebugViewInfo::Cascades::all_or_one;
        int cascade = shown_cascade(choice, std::max(model.cascades, 1));
        if (ImGui::SliderInt("cascade", &cascade, all ? -1 : 0, std::max(model.cascades - 1, 0),
                             cascade < 0 ? "all" : "%d", ImGuiSliderFlags_AlwaysClamp))
            choice.cascade = cascade;
        note("cascade");
    }
    if (row.takes(DebugKey::mip)) {
        ImGui::SliderInt("mip", &choice.mip, 0, row.mip_max, "%d", ImGuiSliderFlags_AlwaysClamp);
        note("mip");
    }
    if (row.takes(DebugKey::channel)) {
        int channel = choice.colouring.channel + 1;
        const int least = row.together ? 0 : 1;
        const auto name = [&row](int i) {
            return i == 0 ? "all" : row.channels[static_cast<std::size_t>(i - 1)].name.data();
        };
        channel = std::max(channel, least);
        if (ImGui::BeginCombo("channel", name(channel))) {
            for (int i = least; i <= row.channel_count(); ++i)
                if (ImGui::Selectable(name(i), i == channel))
                    choice.colouring.channel = i - 1;
            ImGui::EndCombo();
        }
        note("channel");
    }
    slide("gain", choice.colouring.gain, 1e-3, 1e3, "%.3g", ImGuiSliderFlags_Logarithmic);
    note("gain");
    ImGui::Checkbox("flip", &choice.colouring.flip);
    note("flip");
    ImGui::SameLine();
    ImGui::Checkbox("legend", &choice.legend);
    note("legend");
    ImGui::TextWrapped("%s", row.meaning.data());
}

void Panels::camera(const WindowModel& model, ViewChoice& choice, Asked& asked) {
    constexpr std::pair<CameraMode, const char*> modes[] = {{CameraMode::fly, "1 fly"},
                                                            {CameraMode::orbit, "2 orbit"},
                                                            {CameraMode::follow, "3 float"}};
    for (const auto& [mode, name] : modes) {
        if (ImGui::RadioButton(name, model.camera == mode)) {
            asked.mode_changed = true;
            asked.mode = mode;
        }
        note(name + 2);
        ImGui::SameLine();
    }
    ImGui::NewLine();
    double speed_mps = model.speed_mps;
    if (slide("speed", speed_mps, Pilot::speed_min_mps, Pilot::speed_max_mps, "%.1f m/s",
              ImGuiSliderFlags_Logarithmic))
        asked.speed_mps = speed_mps;
    note("speed");
    ImGui::Checkbox("M second camera, the mesh stays", &choice.second_camera);
    note("second camera");
    ImGui::TextWrapped("W A S D, Q E; Shift: faster; drag to look; wheel: speed or distance");
}

Panels::Asked Panels::draw(const WindowModel& model, ViewChoice& choice) {
    Asked asked;
    overlay(model);
    places_.clear();
    box_ = {};
    if (!choice.panels)
        return asked;
    const float letter = ImGui::GetFontSize() / 2;
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    const float width = std::min(width_letters * letter, window.x / 2);
    ImGui::SetNextWindowPos({letter, letter}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({width, window.y - 2 * letter}, ImGuiCond_FirstUseEver);
    ImGui::Begin("Seaway (Tab hides this)");
    ImGui::PushItemWidth(-14 * letter);
    if (header("Connection", true))
        table("connection", model.connection);
    if (header("View", true))
        view(model, choice);
    if (header("Look", false))
        look_file(model, choice, asked);
    if (header("Camera", true))
        camera(model, choice, asked);
    if (header("Probe", true)) {
        table("probe", model.probe);
        plot("trace", model.trace);
        if (!model.trace.values.empty()) {
            asked.forget_probe = ImGui::Button("forget it");
            note("forget");
        }
    }
    if (header("Sea", true)) {
        table("sea", model.sea);
        plot("spectrum", model.spectrum);
    }
    if (header("Rates", false))
        table("rates", model.rates);
    if (header("Time a pass", false))
        table("passes", model.passes);
    ImGui::PopItemWidth();
    const ImVec2 low = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    box_ = {{low.x, low.y}, {low.x + size.x, low.y + size.y}};
    ImGui::End();
    return asked;
}

} // namespace seaway::client
