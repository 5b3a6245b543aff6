// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <gtest/gtest.h>

#include "client/apps/ctl_status.h"

namespace seaway::client {
namespace {

const std::string sessions = R"({"sessions": 3, "listed": [{"bytes_waiting": 4096}]})";
const std::string before = R"({"cpu_s": 12.0})";
const std::string state =
    R"({"cpu_s": 12.5, "journal": {"shared": true, "changes": 5, "played": 4, "counted": 69,
        "counted_max": 10000, "peers": 2, "clock_ahead_ms": 0.25,
        "clock_error_ms": 0.5, "unheard_s": 0.1, "stale": false, "why": ""}})";

std::string without(std::string text, const std::string& key) {
    const std::size_t at = text.find('"' + key + '"');
    EXPECT_NE(at, std::string::npos) << key;
    return text.replace(at + 1, key.size(), key.size(), 'x');
}

TEST(CtlStatus, a_server_that_says_all_has_its_row) {
    const StatusRow row = status_row("ws://a", "seaway 0.1.0", before, state, 2.0, sessions);
    EXPECT_TRUE(row.certain);
    for (const char* word :
         {"ws://a", "seaway 0.1.0", "ready", "      5      1     0.250     0.500",
          "     2        2   0.25         4    69/10000 "})
        EXPECT_NE(row.text.find(word), std::string::npos) << word << " in " << row.text;
}

// Naive: what those wait for who are listed, of a thousand sessions the 256 that may all be quick.
TEST(CtlStatus, what_waits_is_of_all_sessions_and_of_those_listed_where_a_server_says_no_more) {
    const auto row = [](const std::string& its_sessions) {
        return status_row("ws://a", "seaway 0.1.0", before, state, 2.0, its_sessions).text;
    };
    const std::string all =
        row(R"({"sessions": 1001, "bytes_waiting": 2097152, "listed": [{"bytes_waiting": 4096}]})");
    EXPECT_NE(all.find("     1000   0.25      2048    69/10000 "), std::string::npos) << all;
    EXPECT_NE(row(sessions).find("   0.25         4    69/10000 "), std::string::npos);
}

// In an update of one server after the other.
TEST(CtlStatus, a_server_of_another_version_has_a_row_that_says_so) {
    const auto expect_other = [](const std::string& its_state, const std::string& its_sessions) {
        const StatusRow row =
            status_row("ws://a", "seaway 9", before, its_state, 1.0, its_sessions);
        EXPECT_FALSE(row.certain);
        EXPECT_NE(row.text.find("in other words"), std::string::npos)
            << its_state << its_sessions << row.text;
    };
    for (const char* key : {"cpu_s", "changes", "played", "counted", "peers", "clock_ahead_ms",
                            "clock_error_ms", "unheard_s", "stale", "why"})
        expect_other(without(state, key), sessions);
    for (const char* key : {"sessions", "listed", "bytes_waiting"})
        expect_other(state, without(sessions, key));
    for (const char* other : {"", "{}", "[]", "null", "7", "{\"listed\": 7, \"sessions\": \"\"}",
                              "{\"listed\": [], \"sessions\": 3, \"bytes_waiting\": \"much\"}"})
        expect_other(state, other);
    for (const char* other : {"[]", "7", "{\"journal\": 7}", "{\"journal\": {\"stale\": 2}}"})
        expect_other(other, sessions);
}

} // namespace
} // namespace seaway::client
