// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/log_format.h"

namespace seaway::server {
namespace {

using nlohmann::json;

json read(const std::string& message) {
    const std::string line = json_line("2026-11-23T01:02:03.004+0000", "info", message);
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    return json::parse(line);
}

TEST(JsonLog, a_line_is_one_object_with_time_level_and_message) {
    const json line = read("a sea of 3 cascades");
    EXPECT_EQ(line, (json{{"time", "2026-11-23T01:02:03.004+0000"},
                          {"level", "info"},
                          {"message", "a sea of 3 cascades"}}));
}

TEST(JsonLog, fields_of_an_event_have_their_types) {
    const json fields = read("event=session_closed session=12 peer=127.0.0.1:47 reason=too_slow "
                             "why=\"did not read, 3 messages = all\" open_s=1.25 rate=-3e2 "
                             "administrator=true late=false")["fields"];
    EXPECT_EQ(fields, (json{{"event", "session_closed"},
                            {"session", 12},
                            {"peer", "127.0.0.1:47"},
                            {"reason", "too_slow"},
                            {"why", "did not read, 3 messages = all"},
                            {"open_s", 1.25},
                            {"rate", -300.0},
                            {"administrator", true},
                            {"late", false}}));
    EXPECT_TRUE(fields["session"].is_number_integer());
}

TEST(JsonLog, whatever_a_line_holds_it_stays_one_object) {
    const char* const odd[] = {"",
                               "event=",
                               "event=\"",
                               "event=a b",
                               "event=a  b=c",
                               "event=a why=\"no end",
                               "event=a why=\"\" x=",
                               "event=nan n=nan i=inf big=99999999999999999999",
                               "event=a time=1 level=2 message=3",
                               "event=\xff\xfe why=\"\x01\n\t\"",
                               "event=\"q\"trailing"};
    for (const char* message : odd)
        EXPECT_TRUE(read(message).is_object()) << message;
    EXPECT_EQ(read("event=a why=\"\" x=")["fields"],
              (json{{"event", "a"}, {"why", ""}, {"x", ""}}));
    // A path in a sentence may hold quotes.
    EXPECT_EQ(read("event=a why=\"q \"d\" x/y: no such file\" n=3")["fields"],
              (json{{"event", "a"}, {"why", "q \"d\" x/y: no such file"}, {"n", 3}}));
    // Fields never take the place of what the line itself says.
    EXPECT_EQ(read("event=a time=1")["time"], "2026-11-23T01:02:03.004+0000");
}

} // namespace
} // namespace seaway::server
