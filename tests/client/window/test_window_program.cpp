// SPDX-License-Identifier: Apache-2.0
// seaway-view with a window as its users run it.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "tests/client/window/window_fixture.h"
#include "tests/client/window/x11.h"

namespace seaway::client {
namespace {

struct Outcome {
    int code = -1;
    std::string text; ///< stderr
};

Outcome run(const std::string& environment) {
    const std::string command =
        environment + " " SEAWAY_BIN_DIR "/seaway-view ws://127.0.0.1:1 2>&1 >/dev/null";
    Outcome outcome;
    FILE* pipe = popen(command.c_str(), "r");
    std::array<char, 256> line{};
    while (fgets(line.data(), line.size(), pipe) != nullptr)
        outcome.text += line.data();
    outcome.code = WEXITSTATUS(pclose(pipe));
    return outcome;
}

TEST(WindowProgram, says_in_one_line_that_there_is_no_display_and_what_to_use_instead) {
    const Outcome unset = run("env -u DISPLAY -u WAYLAND_DISPLAY");
    EXPECT_EQ(unset.code, 3);
    EXPECT_THAT(unset.text, testing::HasSubstr("DISPLAY is not set"));
    const Outcome silent = run("env -u WAYLAND_DISPLAY DISPLAY=:4242");
    EXPECT_EQ(silent.code, 3);
    EXPECT_THAT(silent.text, testing::HasSubstr("DISPLAY=:4242 cannot be opened"));
    for (const Outcome& outcome : {unset, silent}) {
        EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
        EXPECT_THAT(outcome.text, testing::HasSubstr("--offscreen"));
    }
}

class WindowProcess : public WindowTest {
  protected:
    pid_t start(const std::string& url) {
        const pid_t pid = fork();
        if (pid == 0) {
            const std::string program = SEAWAY_BIN_DIR "/seaway-view";
            execl(program.c_str(), program.c_str(), url.c_str(), "--window", "480x300", "--quality",
                  "low", nullptr);
            _exit(127);
        }
        return pid;
    }
    std::string wait_for_window() {
        for (int i = 0; i < 600; ++i) {
            if (std::string id = window_id(); !id.empty())
                return id;
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        return "";
    }
    /// Its exit code; -1: it still runs after so long.
    static int wait(pid_t pid, std::chrono::milliseconds limit) {
        const auto deadline = std::chrono::steady_clock::now() + limit;
        int status = 0;
        while (waitpid(pid, &status, WNOHANG) != pid) {
            if (std::chrono::steady_clock::now() > deadline) {
                kill(pid, SIGKILL);
                waitpid(pid, &status, 0);
                return -1;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
    }
};

TEST_F(WindowProcess, a_window_that_is_closed_ends_the_program_within_two_seconds) {
    const pid_t pid = start(url_);
    const std::string id = wait_for_window();
    ASSERT_FALSE(id.empty());
    // Until the sea is in it: more light than the panels alone have.
    for (int i = 0; i < 600 && display_->shot(480, 300).row(280, 400, 480) < 5; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_GT(display_->shot(480, 300).row(280, 400, 480), 5);
    ASSERT_TRUE(tests::ask_to_close(display_->name(), std::stoul(id)));
    EXPECT_EQ(wait(pid, std::chrono::seconds(2)), 0);
}

// A host that takes the call and says nothing.
TEST_F(WindowProcess, closes_as_fast_while_it_still_tries_to_connect) {
    const int listener = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(listen(listener, 8), 0);
    socklen_t length = sizeof address;
    getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length);
    const pid_t pid = start(fmt::format("ws://127.0.0.1:{}", ntohs(address.sin_port)));
    const std::string id = wait_for_window();
    ASSERT_FALSE(id.empty());
    std::this_thread::sleep_for(std::chrono::seconds(1));
    ASSERT_TRUE(tests::ask_to_close(display_->name(), std::stoul(id)));
    EXPECT_EQ(wait(pid, std::chrono::seconds(2)), 0);
    close(listener);
}

} // namespace
} // namespace seaway::client
