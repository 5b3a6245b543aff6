// SPDX-License-Identifier: Apache-2.0
// Servers that follow one log in NATS, as real programs on loopback, and what their pages say.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/server/change_bench.h"
#include "tests/server/net/clients.h"
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

inline nlohmann::json journal_of(const std::string& url) {
    return nlohmann::json::parse(get(url, "/v1/state").body)["journal"];
}

} // namespace seaway::changes
