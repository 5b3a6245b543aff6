// SPDX-License-Identifier: Apache-2.0
// Servers that follow one log in NATS, as real programs on loopback, and what their pages say.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/server/change_bench.h"
#include "tests/server/net/clients.h"
#include "tests/support/eventually.h"
#include "tests/support/nats_server.h"

namespace seaway::changes {

inline std::vector<std::string> arguments_of(const std::string& journal) {
    std::vector<std::string> words = arguments("");
    words[5] = "--journal";
    words[6] = journal;
    return words;
}

inline tests::HttpAnswer get(const std::string& url, const std::string& path) {
    return tests::ask_http(tests::port_of(url), path, "GET", std::string("Bearer ") + token);
}

/// seaway-ctl, which is answered once the server is sure of its sea: where a busy machine lets it hear nothing of the log for two
/// seconds, it rightly refuses.
inline Said ctl_once_sure(const std::string& url, const std::vector<std::string>& words) {
    Said said{};
    EXPECT_TRUE(tests::eventually([&] {
        said = ctl(url, words);
        return said.words.find("the sea cannot be changed now") == std::string::npos;
    })) << said.words;
    return said;
}

inline nlohmann::json journal_of(const std::string& url) {
    return nlohmann::json::parse(get(url, "/v1/state").body)["journal"];
}

} // namespace seaway::changes
