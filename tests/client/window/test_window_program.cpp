// SPDX-License-Identifier: Apache-2.0
// seaway-view with a window as its users run it.
#include <optional>

#include <gmock/gmock.h>

#include "tests/client/window/window_fixture.h"
#include "tests/client/window/x11.h"
#include "tests/support/eventually.h"
#include "tests/support/listener.h"
#include "tests/support/program.h"
#include "tests/support/server_process.h"

namespace seaway::client {
namespace {

tests::Output run(const std::string& environment) {
    return tests::run_program("seaway-view", "ws://127.0.0.1:1", {}, environment);
}

TEST(WindowProgram, says_in_one_line_that_there_is_no_display_and_what_to_use_instead) {
    const tests::Output unset = run("env -u DISPLAY -u WAYLAND_DISPLAY");
    EXPECT_EQ(unset.status, 3);
    EXPECT_THAT(unset.err, testing::HasSubstr("DISPLAY is not set"));
    const tests::Output silent = run("env -u WAYLAND_DISPLAY DISPLAY=:4242");
    EXPECT_EQ(silent.status, 3);
    EXPECT_THAT(silent.err, testing::HasSubstr("DISPLAY=:4242 cannot be opened"));
    for (const tests::Output& outcome : {unset, silent}) {
        EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
        EXPECT_THAT(outcome.err, testing::HasSubstr("--offscreen"));
    }
}

class WindowProcess : public WindowTest {
  protected:
    static tests::ServerProcess start(const std::string& url) {
        return tests::ServerProcess({url, "--window", "480x300", "--quality", "low"}, -1,
                                    SEAWAY_BIN_DIR "/seaway-view");
    }
    /// Of ten programs one, asked to close, ends so: on a busy machine a second may be no second of theirs.
    template <class Condition>
    void expect_to_close_within_2_s(const std::string& url, const Condition& looks_as_it_should) {
        std::optional<int> code;
        for (int i = 0; i < 10 && !code; ++i) {
            tests::ServerProcess view = start(url);
            const std::string id = wait_for_window();
            ASSERT_FALSE(id.empty());
            looks_as_it_should();
            ASSERT_TRUE(tests::ask_to_close(display_->name(), std::stoul(id)));
            code = view.wait_for_exit(std::chrono::seconds(2));
            if (!code) { // late is all that it may be
                ASSERT_EQ(view.wait_for_exit(std::chrono::seconds(60)), 0);
            }
        }
        EXPECT_EQ(code, 0);
    }
    std::string wait_for_window() {
        std::string id;
        tests::eventually([&] { return !(id = window_id()).empty(); });
        return id;
    }
};

TEST_F(WindowProcess, a_window_that_is_closed_ends_the_program_within_two_seconds) {
    expect_to_close_within_2_s(url_, [] {
        // Until the sea is in it: more light than the panels alone have.
        EXPECT_TRUE(
            tests::eventually([] { return display_->shot(480, 300).row(280, 400, 480) > 5; }));
    });
}

// A host that takes the call and says nothing.
TEST_F(WindowProcess, closes_as_fast_while_it_still_tries_to_connect) {
    const tests::Listener silent;
    expect_to_close_within_2_s(fmt::format("ws://127.0.0.1:{}", silent.port()),
                               [] { std::this_thread::sleep_for(std::chrono::seconds(1)); });
}

} // namespace
} // namespace seaway::client
