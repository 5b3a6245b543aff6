// SPDX-License-Identifier: Apache-2.0
#include "client/window/viewer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/text_file.h"
#include "client/view/look_file.h"
#include "client/window/spectrum_curve.h"
#include "gpu/call.h"

namespace seaway::client {

namespace {

constexpr double frame_s = 1.0 / 60; ///< no faster, where the screen sets no pace
constexpr double settled_s =
    0.25;                        ///< a window that changes its size is drawn anew when it has ended
constexpr double stale_s = 0.25; ///< what is older is not of now
constexpr double stale_brightness = 0.45;
constexpr double longest_step_s = 0.25; ///< after a pause nothing jumps
constexpr double crest_heights = 2;     ///< no crest is higher than so many significant heights

} // namespace

Viewer::Viewer(const ViewOptions& options)
    : options_(options), wanted_since_(Clock::now()), pilot_(options.camera),
      live_at_(Clock::now()), stepped_(Clock::now()), measured_(Clock::now()) {
    choice_.look = options.look;
    if (!options.look_path.empty())
        choice_.look_path = options.look_path;
    choice_.debug = options.debug;
    for (std::size_t i = 0; i < quality_table.size(); ++i)
        if (quality_table[i].name == options.quality.name)
            choice_.quality = i;
}

Result<std::unique_ptr<Viewer>> Viewer::open(const ViewOptions& options, const OpenSea& open_sea,
                                             bool validation) {
    std::unique_ptr<Viewer> made(new Viewer(options));
    SEAWAY_TRY(made->create(open_sea, validation));
    return made;
}

OpenSea Viewer::streamed(const ConnectOptions& connect, const TileLimits& limits) {
    return [=](const std::shared_ptr<gpu::Device>&) {
        return Result<std::unique_ptr<SeenSea>>(std::make_unique<StreamedSea>(connect, limits));
    };
}

Result<void> Viewer::create(const OpenSea& open_sea, bool validation) {
    const std::string& shown = options_.scene.empty() ? options_.url : options_.scene;
    SEAWAY_TRY_LET(window_, GlfwWindow::open("Seaway " + shown, options_.camera.width,
                                             options_.camera.height));
    SEAWAY_TRY_LET(device_,
                   gpu::Device::create({.pick = options_.device,
                                        .draws = true,
                                        .validation = validation,
                                        .instance_extensions = window_->instance_extensions(),
                                        .device_extensions = {"VK_KHR_swapchain"}}));
    Result<gpu::Swapchain> swapchain = gpu::Swapchain::create(
        *device_, [this](VkInstance instance) { return window_->make_surface(instance); });
    if (!swapchain)
        return swapchain.error();
    swapchain_.emplace(std::move(*swapchain));
    for (gpu::Commands& commands : commands_) {
        SEAWAY_TRY_LET(commands, gpu::Commands::create(*device_));
    }
    SEAWAY_TRY_LET(gui_, Gui::create(*device_, *window_, *swapchain_));
    window_->set_taken([this](double x, double y) { return panels_.taken(x, y); });
    SEAWAY_TRY_LET(sea_, open_sea(device_));
    live_at_ = Clock::now();
    return {};
}

Viewer::~Viewer() {
    sea_.reset();
    if (device_)
        (void)device_->wait_idle();
}

double Viewer::age_s() const {
    return seconds_since(live_at_);
}

Result<bool> Viewer::step() {
    const double since_s = seconds_since(stepped_);
    window_->poll(model_.stale_s ? frame_s : std::max(frame_s - since_s, 0.0));
    if (window_->should_close())
        return false;
    const double passed_s = std::min(seconds_since(stepped_), longest_step_s);
    stepped_ = Clock::now();
    const glm::ivec2 pixels = window_->pixels();
    if (pixels.x == 0 || pixels.y == 0) { // minimised
        window_->poll(0.1);
        return true;
    }
    take_click(); // on what is shown, before that is another moment's
    SEAWAY_TRY(take_sea());
    SEAWAY_TRY(fit_renderer(pixels));
    gui_->begin();
    take_input(passed_s);
    move_with_the_sea(passed_s);
    if (probe_)
        probe_->read(*points_, frame_->time_us);
    SEAWAY_TRY(draw_sea());
    measure();
    fill_model();
    gui_->background(model_.stale_s ? stale_brightness : 1);
    const Panels::Asked asked = panels_.draw(model_, choice_);
    if (asked.mode_changed)
        pilot_.choose(asked.mode);
    if (asked.speed_mps > 0)
        pilot_.set_speed(asked.speed_mps);
    if (asked.load_look) {
        model_.look_said = load_look(choice_);
        skies_.read_again(); // its picture may have been mended meanwhile
    }
    if (asked.save_look)
        model_.look_said = save_look(choice_);
    if (asked.forget_probe)
        probe_.reset();
    SEAWAY_TRY(show(pixels)); // what panels have set is drawn in the next frame
    return true;
}

Result<void> Viewer::take_sea() {
    SEAWAY_TRY_LET(std::optional<SeenSea::Moment> now, sea_->now());
    if (!now)
        return {};
    frame_ = std::move(now->frame);
    points_ = std::move(now->points);
    live_at_ = Clock::now();
    if (now->state != state_) {
        state_ = std::move(now->state);
        model_.spectrum = spectrum_curve(state_->scene);
    }
    return {};
}

void Viewer::take_input(double seconds) {
    const bool typing = gui_->wants_keys();
    for (const GlfwWindow::Command command : window_->take_commands(typing))
        switch (command) {
        case GlfwWindow::Command::fly:
            pilot_.choose(CameraMode::fly);
            break;
        case GlfwWindow::Command::orbit:
            pilot_.choose(CameraMode::orbit);
            break;
        case GlfwWindow::Command::follow:
            pilot_.choose(CameraMode::follow);
            break;
        case GlfwWindow::Command::second_camera:
            choice_.second_camera = !choice_.second_camera;
            break;
        case GlfwWindow::Command::panels:
            choice_.panels = !choice_.panels;
            break;
        }
    pilot_.steer(window_->take_steering(typing), seconds);
    if (!choice_.second_camera)
        mesh_camera_ = pilot_.camera();
}

void Viewer::move_with_the_sea(double seconds) {
    if (!points_ || age_s() > stale_s)
        return;
    const auto at = [&](double x_m, double y_m) {
        return points_->answer({x_m, y_m, frame_->time_us});
    };
    if (pilot_.mode() == CameraMode::follow) {
        const Float& on = pilot_.floating();
        const sea::Answer answer = at(on.x_m, on.y_m);
        pilot_.ride(answer.height_m, {answer.velocity_mps[0], answer.velocity_mps[1]}, seconds);
    } else if (pilot_.mode() == CameraMode::orbit &&
               camera().z_m < crest_heights * frame_->significant_height_m) {
        pilot_.stay_above(at(camera().x_m, camera().y_m).height_m);
    }
}

Camera Viewer::seen_by() const {
    Camera seen = camera();
    seen.width = std::max(drawn_pixels_.x, 1);
    seen.height = std::max(drawn_pixels_.y, 1);
    return seen;
}

void Viewer::take_click() {
    const std::optional<glm::dvec2> click = window_->take_click();
    if (!click || !points_)
        return;
    const glm::dvec2 at = 2.0 * *click / glm::dvec2(window_->points()) - 1.0;
    const std::optional<glm::dvec2> place =
        where_ray_meets(*points_, seen_by(), at.x, at.y, frame_->time_us,
                        crest_heights * frame_->significant_height_m);
    if (!place)
        return;
    probe_.emplace(*place);
    probe_->read(*points_, frame_->time_us);
    // A window whose output nobody reads goes on.
    (void)write_out(stdout, probe_line(*probe_));
}

Result<void> Viewer::fit_renderer(const glm::ivec2& pixels) {
    if (pixels != wanted_pixels_) {
        wanted_pixels_ = pixels;
        wanted_since_ = Clock::now();
    }
    const bool other_quality = choice_.quality != drawn_quality_;
    const bool other_size = pixels != drawn_pixels_ && pixels != refused_pixels_ &&
                            seconds_since(wanted_since_) > settled_s;
    if (renderer_ && !other_quality && !other_size)
        return {};
    const bool first = !renderer_;
    if (!first && !before_) // the last that has drawn
        before_ = Fit{drawn_pixels_, drawn_quality_};
    const Result<void> made = create_renderer(pixels, choice_.quality);
    refused_pixels_ = {};
    fit_problem_.clear();
    if (made || first)
        return made;
    return go_back(pixels, choice_.quality, made.error());
}

Result<void> Viewer::go_back(const glm::ivec2& pixels, std::size_t quality, const Error& why) {
    fit_problem_ = fmt::format("{}, {} x {}: {}", quality_table[quality].name, pixels.x, pixels.y,
                               why.message);
    const Fit to = *std::exchange(before_, std::nullopt);
    choice_.quality = to.quality; // not tried again before something else is asked for
    refused_pixels_ = pixels;
    return create_renderer(to.pixels, to.quality);
}

Result<void> Viewer::create_renderer(const glm::ivec2& pixels, std::size_t quality) {
    if (renderer_)
        SEAWAY_TRY(renderer_->finish());
    SEAWAY_TRY(device_->wait_idle());
    gui_->set_picture(nullptr);
    picture_is_set_ = false;
    renderer_.reset(); // two do not lie in memory at once
    Result<Renderer> made = Renderer::create(
        *device_, pixels.x, pixels.y, {.quality = options_.as_dense(quality_table[quality])});
    if (!made)
        return made.error();
    renderer_.emplace(std::move(*made));
    drawn_pixels_ = pixels;
    drawn_quality_ = quality;
    drawn_inputs_ = {};
    return {};
}

Viewer::Inputs Viewer::inputs() const {
    std::vector<double> values{static_cast<double>(choice_.debug.view),
                               static_cast<double>(choice_.debug.cascade),
                               static_cast<double>(choice_.debug.mip),
                               static_cast<double>(choice_.debug.colouring.channel),
                               choice_.debug.colouring.gain,
                               choice_.debug.colouring.bias,
                               static_cast<double>(choice_.debug.colouring.flip),
                               static_cast<double>(choice_.debug.legend),
                               static_cast<double>(frame_->time_us)};
    for (const Camera& of : {camera(), mesh_camera_})
        values.insert(values.end(), {of.x_m, of.y_m, of.z_m, of.yaw_deg, of.pitch_deg});
    return {std::move(values), to_toml(choice_.look)};
}

/// What cannot be shown - a level that a map does not have, a scene that is not told - is said, and the picture stays: false,
/// and before the first one there is none.
Result<bool> Viewer::draw_view(const SeaFrame& frame, const Sky& sky) {
    DebugChoice debug = choice_.debug;
    debug.cascade = std::min(debug.cascade, static_cast<int>(frame.cascades.size()) - 1);
    const std::string untold;
    const DebugMoment moment{frame, sky, state_ ? state_->scene : untold, choice_.look.bloom};
    const double exposure = exposure_of(choice_.look, exposure_by_light(sky.white_radiance()));
    const Result<void> fits = check_debug(debug, frame, renderer_->options());
    debug_problem_ = fits ? "" : fits.error().message;
    if (!fits)
        return false;
    if (is_table(debug)) {
        const Result<Picture> numbers = debug_.numbers(*renderer_, moment, seen_by(), debug);
        debug_problem_ = numbers ? "" : numbers.error().message;
        if (!numbers)
            return false;
        SEAWAY_TRY(renderer_->develop_there(*numbers, debug_.display(moment, debug, exposure)));
    } else {
        SEAWAY_TRY(renderer_->draw(frame, seen_by(), sky, debug,
                                   debug_.display(moment, debug, exposure), Wanted::nothing,
                                   choice_.second_camera ? &mesh_camera_ : nullptr));
    }
    model_.legend = debug_.legend(moment, debug, drawn_pixels_.x, drawn_pixels_.y);
    model_.legend_pixels = drawn_pixels_;
    return true;
}

Result<void> Viewer::draw_sea() {
    if (!frame_)
        return {};
    Inputs wanted = inputs();
    if (wanted == drawn_inputs_ && skies_.settled()) // it stands on the device
        return {};
    const Look& look = choice_.look;
    const Sky sky = sky_of_frame(skies_, look, camera(), frame_->time_us);
    SeaFrame frame = *frame_;
    set_water(frame, look);
    const Result<bool> made = draw_view(frame, sky);
    if (!made && before_ && gpu::is_out_of_memory(made.error())) {
        SEAWAY_TRY(go_back(drawn_pixels_, drawn_quality_, made.error()));
        return draw_sea();
    }
    SEAWAY_TRY_LET(const bool drawn, made);
    if (!drawn)
        return {};
    before_.reset();
    drawn_inputs_ = std::move(wanted);
    ++sea_frames_;
    if (!picture_is_set_) {
        SEAWAY_TRY(device_->wait_idle());
        gui_->set_picture(&renderer_->shown());
        picture_is_set_ = true;
    }
    return {};
}

void Viewer::measure() {
    const double passed_s = seconds_since(measured_);
    if (passed_s < 1)
        return;
    const SeenSea::Counts counts = sea_->counts();
    const auto rate = [&](std::uint64_t now, std::uint64_t then) {
        return static_cast<double>(now - then) / passed_s;
    };
    keyframes_hz_ = rate(counts.keyframes, measured_counts_.keyframes);
    bytes_hz_ = rate(counts.bytes, measured_counts_.bytes);
    frames_hz_ = rate(sea_frames_, measured_frames_);
    measured_counts_ = counts;
    measured_frames_ = sea_frames_;
    measured_ = Clock::now();
}

void Viewer::fill_model() {
    model_.shows_sea = frame_.has_value();
    model_.stale_s.reset();
    if (frame_ && age_s() > stale_s)
        model_.stale_s = age_s();
    model_.notice.clear();
    if (model_.stale_s)
        model_.notice = stale_text(*model_.stale_s);
    else if (frame_)
        model_.notice = !fit_problem_.empty()     ? fit_problem_
                        : !skies_.error().empty() ? skies_.error()
                                                  : debug_problem_;
    else
        model_.notice = "no sea yet: " + sea_->name() +
                        (sea_->reason().empty() ? "" : " (" + sea_->reason() + ")");
    model_.connection = sea_->connection(model_.stale_s);
    model_.rates = sea_->rates(keyframes_hz_, bytes_hz_, frames_hz_);
    model_.sea = state_ ? sea_rows(*state_, frame_->time_us) : std::vector<PanelRow>{};
    model_.passes = renderer_ ? pass_rows(renderer_->pass_times()) : std::vector<PanelRow>{};
    const Probe* probe = probe_ ? &*probe_ : nullptr;
    model_.probe = probe_rows(probe);
    model_.trace = trace_curve(probe);
    model_.probe_mark.reset();
    if (probe && probe->answer())
        model_.probe_mark = on_picture(seen_by(), probe->place_m().x, probe->place_m().y,
                                       probe->answer()->height_m);
    model_.water_of_sea = frame_ ? frame_->water.type : sea::WaterType{};
    model_.cascades = frame_ ? static_cast<int>(frame_->cascades.size()) : 0;
    model_.speed_mps = pilot_.speed_mps();
    model_.camera = pilot_.mode();
}

Result<void> Viewer::show(const glm::ivec2& pixels) {
    SEAWAY_TRY_LET(const gpu::Swapchain::Next next,
                   swapchain_->acquire(static_cast<std::uint32_t>(pixels.x),
                                       static_cast<std::uint32_t>(pixels.y)));
    if (next == gpu::Swapchain::Next::wait) {
        gui_->drop();
        return {};
    }
    gpu::Commands& commands = commands_[swapchain_->flight()];
    SEAWAY_TRY(commands.begin());
    swapchain_->begin(commands);
    SEAWAY_TRY(gui_->record(commands, *swapchain_));
    swapchain_->end(commands);
    SEAWAY_TRY(commands.end());
    return swapchain_->present(commands);
}

} // namespace seaway::client
