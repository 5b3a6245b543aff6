// SPDX-License-Identifier: Apache-2.0
// A server whose sea an administrator changes, and who he is.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "base/result.h"
#include "client/client.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/server_process.h"

namespace seaway::changes {

inline constexpr const char* token = "change-the-sea";

/// Of tests in which any sea will do: one that is cheap to make, to send and to sum. Its name as servers take it, which run at the
/// top of the sources.
inline constexpr const char* small_sea = "tests/data/scenes/small_calm.toml";
inline std::string small_sea_text() {
    return tests::read_file(std::string(SEAWAY_SOURCE_DIR "/") + small_sea);
}

/// Written once: a server that starts may be reading it.
inline std::string token_file() {
    static const std::string path = tests::folder().write("admin.token", std::string(token) + '\n');
    return path;
}

inline std::vector<std::string> arguments(const std::string& data_dir) {
    return {small_sea,    "--listen", "127.0.0.1:0",        "--device",  "native",
            "--data-dir", data_dir,   "--admin-token-file", token_file()};
}

/// Of a server that serves this text natively.
inline std::vector<std::string> natively(const std::string& name, const std::string& scene) {
    return {tests::folder().write(name, scene), "--listen", "127.0.0.1:0", "--device", "native"};
}

inline std::unique_ptr<client::Client> connect(const std::string& url) {
    Result<std::unique_ptr<client::Client>> client =
        client::Client::connect({.url = url, .timeout_s = 60});
    EXPECT_TRUE(client) << (client ? "" : client.error().message);
    return client ? std::move(*client) : nullptr;
}

/// That the sea of a client is there.
inline void wait_until(client::Client& client, double time_s) {
    while (sea::seconds_from_us(client.now_us()) < time_s)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

struct Said {
    int code;
    std::string words;
};

/// seaway-ctl with these words behind URL and token.
inline Said ctl(const std::string& url, std::vector<std::string> words,
                const std::string& with_token = token_file()) {
    std::vector<std::string> all{SEAWAY_BIN_DIR "/seaway-ctl", url};
    if (!with_token.empty())
        all.insert(all.end(), {"--token-file", with_token});
    all.insert(all.end(), words.begin(), words.end());
    std::string line;
    for (const std::string& word : all)
        line += "'" + word + "' ";
    const tests::Output ran = tests::run_command(line);
    return {ran.status, ran.said()};
}

/// A number of the JSON that `set` prints.
inline double number(const std::string& json, const std::string& key) {
    const std::size_t at = json.find("\"" + key + "\": ");
    EXPECT_NE(at, std::string::npos) << json;
    return at == std::string::npos ? 0 : std::stod(json.substr(at + key.size() + 4));
}

/// The client's own answers are the exact ones of the server, and never those of keyframes. All waves are there: of
/// 0.008 m, on a slope.
inline void expect_right(client::Client& client, std::span<const sea::QueryPoint> points,
                         double error_m_max = 0.015) {
    Result<std::vector<sea::Answer>> own = Error{"not yet"};
    // A busy machine lets a client hear nothing for seconds, whose bounds grow then.
    ASSERT_TRUE(tests::eventually([&] {
        own = client.sample(points);
        return !own || std::ranges::none_of(*own, [](const sea::Answer& answer) {
            return (answer.flags & sea::answer_stale) != 0;
        });
    }));
    ASSERT_TRUE(own) << own.error().message;
    const auto exact = client.ask(points, {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(exact) << exact.error().message;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if ((*own)[i].flags & sea::answer_folded)
            continue;
        EXPECT_LE(std::abs((*own)[i].height_m - (*exact)[i].height_m),
                  (*own)[i].error_m + (*exact)[i].error_m)
            << points[i].time_us;
        EXPECT_LE((*own)[i].error_m, error_m_max) << points[i].time_us;
    }
}

} // namespace seaway::changes
