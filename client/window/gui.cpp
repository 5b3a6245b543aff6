// SPDX-License-Identifier: Apache-2.0
#include "client/window/gui.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include "shaders/view/gui_frag.h"
#include "shaders/view/gui_vert.h"

namespace seaway::client {

namespace {

constexpr gpu::ExpectedBinding bindings[] = {{"Vertices", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                             {"pane", VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
                                             {"image", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
static_assert(sizeof(ImDrawVert) == 20 && offsetof(ImDrawVert, uv) == 8 &&
                  offsetof(ImDrawVert, col) == 16,
              "vertices are as shaders/view/gui.vert reads them");

constexpr float font_pixels = 13;
constexpr std::uintptr_t font_texture = 1, picture_texture = 2;

/// A pointer in some versions of ImGui, a number in others.
template <class Id = ImTextureID>
Id texture_id(std::uintptr_t number) {
    if constexpr (std::is_pointer_v<Id>)
        return reinterpret_cast<Id>(number);
    else
        return static_cast<Id>(number);
}

Result<void> grow(gpu::Device& device, gpu::Buffer& buffer, const char* name, std::size_t bytes,
                  bool& bound) {
    if (buffer.size_bytes() >= bytes)
        return {};
    SEAWAY_TRY_LET(buffer, gpu::Buffer::create(device, name, std::max<std::size_t>(2 * bytes, 4096),
                                               gpu::BufferKind::upload));
    bound = false;
    return {};
}

} // namespace

Result<std::unique_ptr<Gui>> Gui::create(gpu::Device& device, const GlfwWindow& window,
                                         const gpu::Swapchain& shows) {
    std::unique_ptr<Gui> made(new Gui(device));
    made->encodes_ = shows.encodes();
    ImGui::CreateContext();
    made->has_context_ = true;
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr; // a viewer leaves no files behind
    io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    const auto scale = static_cast<float>(window.scale());
    ImFontConfig font;
    font.SizePixels = std::round(font_pixels * scale);
    io.Fonts->AddFontDefault(&font);
    ImGui::GetStyle().ScaleAllSizes(scale);
    ImGui::GetStyle().WindowRounding = 3 * scale;
    if (!ImGui_ImplGlfw_InitForOther(window.get(), true))
        return Error{"the window's panels cannot be set up"};
    made->has_window_ = true;
    SEAWAY_TRY_LET(made->pipeline_, gpu::GraphicsPipeline::create(
                                        device, "panels", gui_vert, gui_frag, bindings,
                                        {.colour_format = shows.format(), .blended = true}));
    SEAWAY_TRY_LET(made->sampler_, gpu::create_sampler(device, {}));
    SEAWAY_TRY(made->create_font());
    for (Flight& flight : made->flights_) {
        SEAWAY_TRY_LET(flight.pane,
                       gpu::Buffer::create(device, "pane", sizeof(Pane), gpu::BufferKind::upload));
    }
    return made;
}

Gui::~Gui() {
    if (has_window_)
        ImGui_ImplGlfw_Shutdown();
    if (has_context_)
        ImGui::DestroyContext();
}

Result<void> Gui::create_font() {
    unsigned char* texels = nullptr;
    int width = 0, height = 0;
    ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    fonts.GetTexDataAsRGBA32(&texels, &width, &height);
    const auto bytes = 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    SEAWAY_TRY_LET(font_, gpu::Image::create(*device_, "font",
                                             {.width = static_cast<std::uint32_t>(width),
                                              .height = static_cast<std::uint32_t>(height),
                                              .format = VK_FORMAT_R8G8B8A8_UNORM}));
    SEAWAY_TRY_LET(const gpu::Buffer staging,
                   gpu::Buffer::create(*device_, "font", bytes, gpu::BufferKind::upload));
    std::memcpy(staging.mapped().data(), texels, bytes);
    fonts.SetTexID(texture_id(font_texture));
    return gpu::run_once(*device_, [&](gpu::Commands& commands) {
        gpu::record_upload(commands, staging, font_, 4);
    });
}

void Gui::set_picture(const gpu::Image* picture) {
    picture_ = picture;
    for (Flight& flight : flights_)
        flight.bound = false;
}

void Gui::begin() {
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
}

void Gui::background(double brightness) {
    if (picture_ == nullptr)
        return;
    const auto share = static_cast<int>(std::lround(255 * std::clamp(brightness, 0.0, 1.0)));
    ImGui::GetBackgroundDrawList()->AddImage(texture_id(picture_texture), {0, 0},
                                             ImGui::GetIO().DisplaySize, {0, 0}, {1, 1},
                                             IM_COL32(share, share, share, 255));
}

bool Gui::wants_keys() const {
    return ImGui::GetIO().WantTextInput;
}

void Gui::drop() {
    ImGui::EndFrame();
}

Result<void> Gui::bind(Flight& flight) {
    if (flight.bound)
        return {};
    const auto set = [&](const gpu::Image& image) {
        const gpu::Resource resources[] = {
            gpu::whole(flight.vertices), gpu::whole(flight.pane),
            gpu::sampled(sampler_.get(), image.view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)};
        return pipeline_.bind(*device_, resources);
    };
    SEAWAY_TRY_LET(flight.font, set(font_));
    if (picture_ != nullptr) {
        SEAWAY_TRY_LET(flight.picture, set(*picture_));
    }
    flight.bound = true;
    return {};
}

Result<void> Gui::fill(Flight& flight, const ImDrawData& data) {
    SEAWAY_TRY(grow(*device_, flight.vertices, "panel vertices",
                    static_cast<std::size_t>(data.TotalVtxCount) * sizeof(ImDrawVert),
                    flight.bound));
    SEAWAY_TRY(grow(*device_, flight.indices, "panel indices",
                    static_cast<std::size_t>(data.TotalIdxCount) * sizeof(ImDrawIdx),
                    flight.bound));
    std::byte* vertex = flight.vertices.mapped().data();
    std::byte* index = flight.indices.mapped().data();
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        const auto vertices = static_cast<std::size_t>(list.VtxBuffer.size_in_bytes());
        const auto indices = static_cast<std::size_t>(list.IdxBuffer.size_in_bytes());
        std::memcpy(vertex, list.VtxBuffer.Data, vertices);
        std::memcpy(index, list.IdxBuffer.Data, indices);
        vertex += vertices;
        index += indices;
    }
    const Pane pane{2 / data.DisplaySize.x,
                    2 / data.DisplaySize.y,
                    -1 - 2 * data.DisplayPos.x / data.DisplaySize.x,
                    -1 - 2 * data.DisplayPos.y / data.DisplaySize.y,
                    encodes_,
                    {}};
    std::memcpy(flight.pane.mapped().data(), &pane, sizeof pane);
    return bind(flight);
}

Result<void> Gui::record(gpu::Commands& commands, const gpu::Swapchain& to) {
    ImGui::Render();
    const ImDrawData& data = *ImGui::GetDrawData();
    if (data.TotalIdxCount == 0 || data.DisplaySize.x <= 0 || data.DisplaySize.y <= 0)
        return {};
    Flight& flight = flights_[to.flight()];
    SEAWAY_TRY(fill(flight, data));
    vkCmdBindIndexBuffer(commands.get(), flight.indices.get(), 0,
                         sizeof(ImDrawIdx) == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
    const ImVec2 points(data.FramebufferScale);
    const auto width = static_cast<float>(to.extent().width);
    const auto height = static_cast<float>(to.extent().height);
    int first_vertex = 0;
    std::uint32_t first_index = 0;
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        for (const ImDrawCmd& draw : list.CmdBuffer) {
            const float left = std::max((draw.ClipRect.x - data.DisplayPos.x) * points.x, 0.0f);
            const float top = std::max((draw.ClipRect.y - data.DisplayPos.y) * points.y, 0.0f);
            const float right = std::min((draw.ClipRect.z - data.DisplayPos.x) * points.x, width);
            const float bottom = std::min((draw.ClipRect.w - data.DisplayPos.y) * points.y, height);
            if (right <= left || bottom <= top)
                continue;
            const VkRect2D clip{{static_cast<std::int32_t>(left), static_cast<std::int32_t>(top)},
                                {static_cast<std::uint32_t>(right - std::floor(left)),
                                 static_cast<std::uint32_t>(bottom - std::floor(top))}};
            vkCmdSetScissor(commands.get(), 0, 1, &clip);
            const bool of_the_sea = draw.GetTexID() == texture_id(picture_texture);
            pipeline_.record_bind(commands, of_the_sea ? flight.picture : flight.font);
            vkCmdDrawIndexed(commands.get(), draw.ElemCount, 1, first_index + draw.IdxOffset,
                             first_vertex + static_cast<int>(draw.VtxOffset), 0);
        }
        first_vertex += list.VtxBuffer.Size;
        first_index += static_cast<std::uint32_t>(list.IdxBuffer.Size);
    }
    return {};
}

} // namespace seaway::client
