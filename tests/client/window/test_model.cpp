// SPDX-License-Identifier: Apache-2.0
// What panels show, without pixels.
#include <unistd.h>

#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/view/sea/sea_source.h"
#include "client/window/feed.h"
#include "client/window/glfw_window.h"
#include "client/window/model.h"
#include "client/window/spectrum_curve.h"
#include "sea/basics/constants.h"
#include "tests/client/view/small_seas.h"
#include "tests/client/view/synthetic_sea.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/listener.h"
#include "tests/support/server_process.h"

namespace seaway::client {
namespace {

using testing::HasSubstr;

std::string value_of(const std::vector<PanelRow>& rows, const std::string& label) {
    for (const PanelRow& row : rows)
        if (row.label == label)
            return row.value;
    return "no row " + label;
}

TEST(Model, looks_are_loaded_and_saved_and_a_bad_one_changes_nothing) {
    ViewChoice choice;
    choice.look.hour = 4.5;
    choice.look.water = sea::WaterType::jerlov_1;
    choice.look.exposure_stops = -1.25; // of the slider: it opens as bright as it was saved
    choice.look_path = tests::folder().file("model_look.toml");
    EXPECT_EQ(save_look(choice), "saved " + choice.look_path);
    ViewChoice other;
    other.look_path = choice.look_path;
    EXPECT_EQ(load_look(other), "loaded " + choice.look_path);
    EXPECT_EQ(other.look, choice.look);
    other.look_path = "/nowhere/look.toml";
    EXPECT_THAT(load_look(other), HasSubstr("cannot read look '/nowhere/look.toml': "));
    EXPECT_THAT(save_look(other), HasSubstr("cannot write look '/nowhere/look.toml': "));
    EXPECT_EQ(other.look, choice.look);
}

TEST(Model, a_connection_says_its_state_and_why) {
    FeedStatus feed;
    std::vector<PanelRow> rows = connection_rows("ws://here:1", feed, nullptr, std::nullopt);
    EXPECT_EQ(value_of(rows, "server"), "ws://here:1");
    EXPECT_EQ(value_of(rows, "state"), "connecting");
    EXPECT_EQ(value_of(rows, "because"), "no row because");
    feed = {.link = Link::waiting, .reason = "no server there", .next_s = 3.26};
    rows = connection_rows("ws://here:1", feed, nullptr, 12.34);
    EXPECT_EQ(value_of(rows, "state"), "next attempt in 3.3 s");
    EXPECT_EQ(value_of(rows, "because"), "no server there");
    EXPECT_EQ(value_of(rows, "sea shown"), "stale, 12.3 s old");
    feed.link = Link::connecting;
    feed.connections = 1;
    EXPECT_EQ(value_of(connection_rows("", feed, nullptr, 1), "state"), "connecting again");
    feed.link = Link::live;
    rows = connection_rows("", feed, nullptr, std::nullopt);
    EXPECT_EQ(value_of(rows, "state"), "live");
    EXPECT_EQ(value_of(rows, "because"), "no row because") << "of the last time; it is over";
    EXPECT_EQ(value_of(rows, "sea shown"), "now");
}

TEST(Feed, stays_away_for_as_long_as_a_server_that_stops_asks) {
    tests::ServerProcess server({"scenes/calm.toml", "--device", "native", "--listen",
                                 "127.0.0.1:0", "--retry-after", "600"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Feed feed({.url = url});
    const auto becomes = [&feed](Link link) {
        return tests::eventually([&] { return feed.status().link == link; });
    };
    ASSERT_TRUE(becomes(Link::live)) << server.log();
    server.send(SIGTERM);
    ASSERT_TRUE(becomes(Link::waiting));
    // It is lost a moment before it is known for how long.
    EXPECT_TRUE(tests::eventually([&] { return feed.status().next_s > 0; }));
    const FeedStatus status = feed.status();
    EXPECT_THAT(status.reason, testing::HasSubstr("shutting_down"));
    EXPECT_GT(status.next_s, 500) << "of the 600, with a minute and more for a busy machine";
    EXPECT_LE(status.next_s, 1200);
}

std::size_t threads() {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator("/proc/self/task"), {}));
}

// Naive: nobody tells its thread to stop, which goes on after the window until its patience with the server ends.
TEST(Feed, leaves_no_thread_that_waits_for_a_silent_server) {
    const tests::Listener silent;
    const std::size_t before = threads();
    int line = -1;
    {
        Feed feed({.url = fmt::format("ws://127.0.0.1:{}", silent.port()), .timeout_s = 600});
        line = silent.accept();
        ASSERT_GE(line, 0) << "it has come";
    }
    EXPECT_TRUE(tests::eventually([&] { return threads() <= before; }));
    ::close(line);
}

// A frame that is still drawn has it. What the feed counted must be there for as long as the client counts: the sanitizers
// see it where it is not.
TEST(Feed, may_go_before_those_who_have_its_client) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    std::shared_ptr<Client> client;
    {
        Feed feed({.url = url});
        EXPECT_TRUE(
            tests::eventually([&] { return feed.client() && feed.status().keyframes > 0; }));
        EXPECT_GT(feed.status().bytes, 0u);
        client = feed.client();
    }
    ASSERT_TRUE(client);
    const sea::TimeUs then_us = client->now_us() + 1'000'000; // some keyframes on
    EXPECT_TRUE(tests::eventually([&] { return client->now_us() >= then_us; }));
    EXPECT_TRUE(client->is_open());
}

// Naive: the surface that is held answers by itself, and knows nothing of what its client may have missed.
TEST(Model, a_probe_says_what_its_client_says_of_a_server_that_is_gone) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Result<std::unique_ptr<Client>> connected =
        Client::connect({.url = url}, {}, {.as_splines = true});
    ASSERT_TRUE(connected) << connected.error().message;
    const std::shared_ptr<Client> client = std::move(*connected);
    const Result<Grant> grant =
        client->subscribe({.fields = drawn_fields}, protocol::limits::credit_default, 60);
    ASSERT_TRUE(grant) << grant.error().message;
    // Later than changes are told ahead, which what streams may not be on a busy machine.
    const sea::QueryPoint point{1, 2, client->now_us() + 60'000'000};
    ASSERT_TRUE(client->hold({&point.time_us, 1}, 60));
    server.send(SIGKILL);
    ASSERT_TRUE(tests::eventually([&] { return client->status().state != LinkState::connected; }));
    Result<LocalSurface> surface = client->surface(point.time_us);
    ASSERT_TRUE(surface) << surface.error().message;
    const ClientPoints points(client, std::move(*surface));
    Probe probe({point.x_m, point.y_m});
    probe.read(points, point.time_us);
    ASSERT_TRUE(probe.answer());
    const Result<std::vector<sea::Answer>> said = client->sample({&point, 1});
    ASSERT_TRUE(said) << said.error().message;
    EXPECT_EQ(probe.answer()->flags, said->front().flags);
    EXPECT_EQ(probe.answer()->error_m, said->front().error_m);
    EXPECT_THAT(value_of(probe_rows(&probe), "flags"), HasSubstr("stale"));
}

TEST(Model, a_sea_is_told_as_it_was_asked_for_and_as_it_is) {
    SeaState state;
    state.requested = {2.5, 9.5, 7.75, 8.25, 260, 31, 0.02};
    state.realised = {2.42, 9.25, 7.5, 8, 247, 29, 0.019};
    state.height_error_m = 0.01;
    state.cascades = {{.length_m = 160, .size = 32, .interval_us = 200'000}};
    state.warnings = {"short waves are left out"};
    const std::vector<PanelRow> rows = sea_rows(state, 12'340'000);
    EXPECT_EQ(value_of(rows, "sea time"), "12.34 s");
    EXPECT_EQ(value_of(rows, "Hs"), "2.50 | 2.42 m");
    EXPECT_EQ(value_of(rows, "Tp"), "9.50 | 9.25 s");
    EXPECT_EQ(value_of(rows, "Tz"), "7.75 | 7.50 s");
    EXPECT_EQ(value_of(rows, "from"), "260.00 | 247.00 deg");
    EXPECT_EQ(value_of(rows, "spread"), "31.00 | 29.00 deg");
    EXPECT_EQ(value_of(rows, "slope, mean square"), "0.0200 | 0.0190");
    EXPECT_EQ(value_of(rows, "cascade 0"), "160 m, 32 points, every 0.2 s");
    EXPECT_EQ(value_of(rows, "warning"), "short waves are left out");
}

TEST(Model, rates_and_passes_have_their_units) {
    FeedStatus feed;
    feed.keyframes = 70;
    feed.grant.error_m = 0.01f;
    feed.grant.credit = 2;
    const std::vector<PanelRow> rates = rate_rows(feed, 7.5, 3.25e6, 24.05);
    EXPECT_EQ(value_of(rates, "frames"), "24.1 a second");
    EXPECT_EQ(value_of(rates, "keyframes"), "7.5 a second, 70 in all");
    EXPECT_EQ(value_of(rates, "maps"), "3.25 MB a second, unpacked");
    EXPECT_EQ(value_of(rates, "rung"), "heights within 0.01 m");
    EXPECT_EQ(value_of(rates, "credit"), "2 keyframes under way");
    const double times_s[] = {0.001, 0.002, 0.003, 0.004, 0.0005, 0.0015, 0.0005};
    const std::vector<PanelRow> passes = pass_rows(times_s);
    EXPECT_EQ(value_of(passes, "maps"), "1.00 ms");
    EXPECT_EQ(value_of(passes, "film"), "0.50 ms");
    EXPECT_EQ(value_of(passes, "all"), "12.50 ms");
    EXPECT_TRUE(pass_rows({}).empty());
}

TEST(Model, a_probe_shows_every_figure_of_the_answer) {
    EXPECT_EQ(value_of(probe_rows(nullptr), ""), "click on the sea");
    Probe probe({12.5, -340.25});
    EXPECT_EQ(value_of(probe_rows(&probe), "height"), "not held");
    EXPECT_EQ(probe_line(probe), "");
    SyntheticSea sea(one_wave(1.0, 100, 2));
    const SeaFrame frame = sea.at(3'250'000);
    const sea::Surface surface = sea.surface(frame);
    probe.read(HeldPoints({surface, true}), frame.time_us);
    const sea::Answer answer = surface.answer({12.5, -340.25, frame.time_us});
    const std::vector<PanelRow> rows = probe_rows(&probe);
    EXPECT_EQ(value_of(rows, "place"), "12.50 m east, -340.25 m north");
    EXPECT_EQ(value_of(rows, "at"), "3.25 s");
    EXPECT_EQ(value_of(rows, "height"),
              fmt::format("{:.3f} m, within {:.2g} m", answer.height_m, answer.error_m));
    EXPECT_THAT(value_of(rows, "velocity"),
                HasSubstr(fmt::format("{:.2f} m/s", answer.velocity_mps[2])));
    EXPECT_THAT(value_of(rows, "normal"), HasSubstr(fmt::format("{:.3f}", answer.normal[2])));
    EXPECT_EQ(value_of(rows, "flags"), "none");
    EXPECT_THAT(probe_line(probe), HasSubstr("x_m=12.5000 y_m=-340.2500 t_s=3.250000 height_m="));
    const Curve trace = trace_curve(&probe); // one sample, at 3.2 s
    ASSERT_EQ(trace.values.size(), 1u);
    EXPECT_NEAR(static_cast<double>(trace.values[0]),
                surface.answer({12.5, -340.25, 3'200'000}).height_m, 1e-6);
}

// The curve's area is the variance: Hs = 4 sqrt(m0).
TEST(Model, a_spectrum_holds_the_energy_that_its_scene_asks_for) {
    const Curve curve = spectrum_curve(R"([sea]
[[sea.system]]
type = "swell"
spectrum = "jonswap"
significant_height_m = 2.0
peak_period_s = 10.0
from_deg = 300
spreading = "cos2s"
spreading_exponent = 10
[[cascade]]
length_m = 500.0
size = 64
)");
    ASSERT_FALSE(curve.values.empty()) << curve.caption;
    double m0 = 0;
    for (const float value : curve.values)
        m0 += static_cast<double>(value) * frequency_max_hz /
              static_cast<double>(curve.values.size() - 1);
    // Beyond 0.5 Hz, five times the peak, lies a thousandth of it; 2.5 mHz steps on a peak 10 times as wide.
    EXPECT_NEAR(4 * std::sqrt(m0), 2.0, 0.02);
    EXPECT_EQ(curve.most, *std::max_element(curve.values.begin(), curve.values.end()));
    EXPECT_THAT(curve.caption, HasSubstr("at 0.100 Hz"));
}

TEST(Model, a_scene_without_a_spectrum_and_one_that_cannot_be_read_say_so) {
    const Curve broken = spectrum_curve("[sea]\nnonsense = 1\n");
    EXPECT_TRUE(broken.values.empty());
    EXPECT_THAT(broken.caption, HasSubstr("nonsense"));
    const Curve names_a_file = // a server's scene opens no file of whoever looks at it
        spectrum_curve("[sea]\n[[sea.system]]\ntype = \"measured\"\nfile = \"/etc/hostname\"\n");
    EXPECT_THAT(names_a_file.caption, HasSubstr("may name no file"));
}

TEST(NoDisplay, the_message_names_the_variable_that_is_wrong) {
    EXPECT_EQ(no_display_message(nullptr, nullptr, ""),
              "no window: DISPLAY is not set; draw to files with --offscreen WxH --out FILE.png");
    EXPECT_THAT(no_display_message("", nullptr, ""), HasSubstr("DISPLAY is not set"));
    EXPECT_THAT(no_display_message(":7", nullptr, "X11: no"),
                HasSubstr("DISPLAY=:7 cannot be opened (X11: no); draw"));
    EXPECT_THAT(no_display_message(nullptr, "wayland-0", ""),
                HasSubstr("WAYLAND_DISPLAY=wayland-0 cannot be opened and DISPLAY is not set"));
}

} // namespace
} // namespace seaway::client
