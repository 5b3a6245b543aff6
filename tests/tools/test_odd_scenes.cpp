// SPDX-License-Identifier: Apache-2.0
// The odd inputs of tests/data/odd_scenes, and inputs that cannot be kept as files: each gets its
// exit status and its words, one line of them, from the programs themselves; what one of them
// refuses all refuse in the same words, what one takes all take.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <sys/stat.h>

#include "client/client.h"
#include "tests/support/program.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using ::testing::HasSubstr;
using tests::folder;
using tests::Output;
using tests::run_program;

const std::string odd_scenes = std::string(SEAWAY_SOURCE_DIR) + "/tests/data/odd_scenes/";
const std::string small_scene = odd_scenes + "wind_of_zero.toml";

struct Case {
    std::string name;
    int status = 0;
    std::string words;
};

std::vector<Case> cases() {
    std::vector<Case> all;
    std::ifstream file(odd_scenes + "cases.tsv");
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || line.front() == '#')
            continue;
        std::istringstream fields(line);
        Case& c = all.emplace_back();
        std::string status;
        std::getline(fields, c.name, '\t');
        std::getline(fields, status, '\t');
        std::getline(fields, c.words, '\t');
        c.status = std::stoi(status);
    }
    return all;
}

void expect_one_line(const Output& output, const Case& c) {
    EXPECT_EQ(output.status, c.status) << c.name << ": " << output.err;
    if (c.status == 0) {
        EXPECT_THAT(output.out, HasSubstr(c.words)) << c.name;
        EXPECT_EQ(output.err, "") << c.name;
    } else {
        EXPECT_THAT(output.err, HasSubstr(c.words)) << c.name;
        EXPECT_EQ(output.error_lines(), 1) << c.name << ": " << output.err;
        EXPECT_EQ(output.out, "") << c.name;
    }
}

/// Of every case, on two threads: a program of a few milliseconds mostly waits for its start.
template <class Check>
void for_each_case(const Check& check) {
    const std::vector<Case> all = cases();
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        for (std::size_t i = next++; i < all.size(); i = next++)
            check(all[i], odd_scenes + all[i].name + ".toml");
    };
    std::thread other(work);
    work();
    other.join();
}

/// Of "seaway-NAME: MESSAGE", the one line of a program that refuses: the message.
std::string refusal(const std::string& err) {
    const std::size_t colon = err.find(": ");
    return err.starts_with("seaway-") && colon != std::string::npos ? err.substr(colon + 2) : err;
}

/// What inspect says of a scene, asked once: three tests hold every case to it.
const Output& inspected(const std::string& scene) {
    static std::mutex mutex;
    static std::map<std::string, Output> said;
    {
        const std::scoped_lock lock(mutex);
        if (const auto known = said.find(scene); known != said.end())
            return known->second;
    }
    Output output = run_program("seaway-inspect", scene);
    const std::scoped_lock lock(mutex);
    return said.emplace(scene, std::move(output)).first->second;
}

std::string inspects_refusal(const std::string& scene) {
    return refusal(inspected(scene).err);
}

TEST(OddScenes, each_gets_its_exit_status_and_one_line_of_its_words) {
    const std::vector<Case> all = cases();
    EXPECT_GE(all.size(), 100u);
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(odd_scenes))
        files += entry.path().extension() == ".toml";
    EXPECT_EQ(files, all.size()) << "a scene without a row, or a row without a scene";
    for_each_case([](const Case& c, const std::string& scene) {
        const Output& output = inspected(scene);
        expect_one_line(output, c);
        if (c.status != 0) {
            EXPECT_THAT(output.err, HasSubstr(c.name + ".toml:")) << "the place";
        }
    });
}

TEST(OddScenes, a_pipe_and_an_endless_device_are_refused_at_once) {
    const std::string pipe = folder().file("pipe");
    std::filesystem::remove(pipe);
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const std::string& odd : {pipe, std::string("/dev/zero")}) {
        expect_one_line(run_program("seaway-inspect", odd), {odd, 2, "a pipe, a device"});
        expect_one_line(run_program("seaway-inspect", small_scene + " --eval " + odd),
                        {odd, 2, "a pipe, a device"});
        const std::string scene =
            folder().write("data_is_odd.toml",
                           "[sea]\n[[sea.system]]\ntype = \"measured\"\nfile = \"" + odd + "\"\n");
        expect_one_line(run_program("seaway-inspect", scene), {odd, 2, "a pipe, a device"});
    }
    expect_one_line(run_program("seaway-inspect", odd_scenes), {"folder", 2, "folder"});
    const std::string large =
        folder().write("large.toml", "# " + std::string(1 << 20, 'x') + "\n[sea]\n");
    expect_one_line(run_program("seaway-inspect", large), {"large", 2, "more than 1048576 bytes"});
    std::string key = "a"; // a level each, of tables within each other
    for (int i = 0; i < 250'000; ++i)
        key += ".a";
    const std::string deep =
        folder().write("deep.toml", "[[weather]]\nset = { " + key + " = 1 }\n");
    expect_one_line(run_program("seaway-inspect", deep), {"deep", 2, "a key of more than 8 parts"});
}

/// Of a program whose standard output cannot be written.
Output into_full_disk(const std::string& name, const std::string& arguments) {
    return run_program(name, arguments + " >/dev/full");
}

TEST(OddScenes, a_full_disk_behind_standard_output_is_an_error) {
    for (const char* arguments : {"", " --format json", " --spectrum 0.5"}) {
        const Output output = into_full_disk("seaway-inspect", small_scene + arguments);
        EXPECT_EQ(output.status, 2) << arguments;
        EXPECT_THAT(output.err, HasSubstr("standard output"));
    }
    for (const char* program : {"seaway-inspect", "seaway-bake"})
        for (const char* flag : {"--help", "--version"})
            EXPECT_NE(into_full_disk(program, flag).status, 0) << program << ' ' << flag;
    EXPECT_NE(into_full_disk("seaway-bake", small_scene +
                                                " --device native --frames 1 --fps 1 --out " +
                                                folder().file("baked"))
                  .status,
              0);
}

// libpng removes what it could not write whole: with rights enough, the device itself. A link stands
// for it here.
TEST(OddScenes, a_picture_is_never_written_over_a_device) {
    const std::string link = folder().file("full.png");
    std::filesystem::create_symlink("/dev/full", link);
    expect_one_line(run_program("seaway-inspect", small_scene + " --plot " + link),
                    {"plot", 2, "full.png': is a pipe, a device"});
    EXPECT_TRUE(std::filesystem::is_symlink(link));
}

TEST(OddScenes, each_is_baked_or_refused_in_the_words_of_inspect) {
    for_each_case([](const Case& c, const std::string& scene) {
        const std::string out = folder().file("baked_" + c.name);
        const Output baked =
            run_program("seaway-bake", scene + " --device native --frames 1 --fps 1 --out " + out);
        EXPECT_EQ(baked.status, c.status) << c.name << ": " << baked.err;
        if (c.status != 0) {
            EXPECT_EQ(refusal(baked.err), inspects_refusal(scene)) << c.name;
            EXPECT_FALSE(std::filesystem::exists(out)) << c.name << ": nothing is begun";
            return;
        }
        std::size_t pictures = 0;
        for (const auto& entry : std::filesystem::directory_iterator(out))
            pictures += entry.path().extension() == ".exr" && entry.file_size() > 0;
        EXPECT_GE(pictures, 1u) << c.name << ": none may leave with 0 having done nothing";
        std::filesystem::remove_all(out);
    });
}

/// One height from maps and one by the exact sum, through the socket.
void expect_served(const std::string& url, const std::string& name) {
    const Result<std::unique_ptr<client::Client>> client =
        client::Client::connect({.url = url, .timeout_s = 60});
    ASSERT_TRUE(client) << name << ": " << client.error().message;
    const sea::QueryPoint point{12.5, -7.25, 1'234'567};
    const auto served = (*client)->ask({&point, 1}, {.timeout_s = 60});
    const auto exact = (*client)->ask({&point, 1}, {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(served) << name << ": " << served.error().message;
    ASSERT_TRUE(exact) << name << ": " << exact.error().message;
    const sea::Answer& answer = served->front();
    EXPECT_TRUE(std::isfinite(answer.height_m) && std::isfinite(answer.error_m)) << name;
    constexpr unsigned unbounded = sea::answer_folded | sea::answer_not_converged;
    if (((answer.flags | exact->front().flags) & unbounded) == 0) {
        EXPECT_LE(std::abs(answer.height_m - exact->front().height_m),
                  answer.error_m + exact->front().error_m)
            << name;
    }
}

TEST(OddScenes, a_server_warns_of_foam_out_of_reach_as_inspect_does) {
    const std::string scene = folder().write(
        "little_foam.toml",
        "[sea]\n[[sea.system]]\ntype = \"wind\"\nspectrum = \"pierson_moskowitz\"\n"
        "wind_speed_10m_mps = 15\nfrom_deg = 250\n[[cascade]]\nlength_m = 500\nsize = 64\n"
        "[foam]\ngain_per_s = 1e-3\n");
    const std::string words = "no threshold of -1 .. 1 gives that with this gain and decay";
    EXPECT_THAT(run_program("seaway-inspect", scene).out, HasSubstr(words));
    tests::ServerProcess server({scene, "--listen", "127.0.0.1:0", "--device", "native"});
    ASSERT_NE(server.wait_until_ready(), "") << server.log();
    EXPECT_THAT(server.log(), HasSubstr(words));
}

TEST(OddScenes, each_is_served_or_refused_in_the_words_of_inspect) {
    for_each_case([](const Case& c, const std::string& scene) {
        tests::ServerProcess server({scene, "--listen", "127.0.0.1:0", "--device", "native"});
        const std::string url = server.wait_until_ready();
        EXPECT_EQ(url.empty(), c.status != 0) << c.name << ": " << server.log();
        if (!url.empty()) {
            expect_served(url, c.name);
            server.send(SIGTERM);
        }
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), c.status)
            << c.name << ": " << server.log();
        if (c.status != 0) {
            EXPECT_EQ(refusal(server.log()), inspects_refusal(scene)) << c.name;
        }
    });
}

} // namespace
} // namespace seaway
