// SPDX-License-Identifier: Apache-2.0
// seaway-query: its points, its options, its output, and the program as a whole.
#include <cmath>
#include <csignal>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/apps/query_output.h"
#include "tests/client/query_options_of.h"
#include "tests/client/wave_server.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace seaway::client {
namespace {

using tests::Output;

Result<std::vector<Place>> places_in(const std::string& text) {
    std::istringstream in(text);
    return read_places(in, "points.csv");
}

TEST(Points, have_an_optional_header_time_and_blank_lines) {
    const auto places = places_in("x_m,y_m,t_s\r\n1, -2.5e3,30\r\n\n+4,5\n");
    ASSERT_TRUE(places) << places.error().message;
    ASSERT_EQ(places->size(), 2u);
    EXPECT_EQ((*places)[0].y_m, -2500);
    EXPECT_EQ((*places)[0].time_s, 30);
    EXPECT_EQ((*places)[1].x_m, 4);
    EXPECT_FALSE((*places)[1].time_s);
    EXPECT_TRUE(places_in("x_m,y_m\n1,2\n"));
    EXPECT_TRUE(places_in("")->empty());
}

TEST(Points, a_wrong_row_is_named_by_file_line_and_value) {
    const std::pair<const char*, const char*> wrong[] = {
        {"1,2\n3\n", "points.csv:2: 1 fields"},
        {"1,2,3,4\n", "points.csv:1: 4 fields"},
        {"x_m,t_s\n1,2\n", "points.csv:1: x_m = 'x_m'"},
        {"1,2\nx_m,y_m\n", "points.csv:2: x_m = 'x_m'"},
        {"1,nan\n", "points.csv:1: y_m = 'nan'"},
        {"1,2e9\n", "between -1e+09 and 1e+09"},
        {"1,2,1e13\n", "t_s = '1e13'"},
        {"1,2 3\n", "y_m = '2 3'"},
        {"1,0x10\n", "y_m = '0x10'"}};
    for (const auto& [text, says] : wrong) {
        const auto places = places_in(text);
        ASSERT_FALSE(places) << text;
        EXPECT_NE(places.error().message.find(says), std::string::npos) << places.error().message;
    }
}

TEST(Options, of_a_full_command_line) {
    const auto read = query_options_of({"ws://a:1", "--at", "-1,2", "-.5,-3", "--at=4,5", "--time",
                                        "-12.5", "--exact", "--format", "csv", "--watch", "10"});
    ASSERT_TRUE(std::holds_alternative<QueryOptions>(read));
    const auto& options = std::get<QueryOptions>(read);
    ASSERT_EQ(options.at.size(), 3u);
    EXPECT_EQ(options.at[0].x_m, -1);
    EXPECT_EQ(options.at[1].x_m, -0.5);
    EXPECT_EQ(options.at[2].y_m, 5);
    EXPECT_EQ(options.time_s, -12.5);
    EXPECT_TRUE(options.exact);
    EXPECT_EQ(options.format, Format::csv);
    EXPECT_EQ(options.watch_hz, 10);
}

TEST(Options, the_address_may_follow_the_points) {
    const auto read = query_options_of({"--at", "1,2", "ws://a:1"});
    ASSERT_TRUE(std::holds_alternative<QueryOptions>(read));
    EXPECT_EQ(std::get<QueryOptions>(read).url, "ws://a:1");
    EXPECT_FALSE(std::get<QueryOptions>(read).time_s) << "now";
}

TEST(Options, that_make_no_sense_are_exit_code_2) {
    const std::vector<const char*> wrong[] = {
        {"--at", "1,2"},
        {"ws://a:1"},
        {"localhost", "--at", "1,2"},
        {"ws://a:1", "--at", "1"},
        {"ws://a:1", "--at", "1,2", "--time", "soon"},
        {"ws://a:1", "--at", "1,2", "--exact", "--local"},
        {"ws://a:1", "--at", "1,2", "--from", "scene"},
        {"ws://a:1", "--at", "1,2", "--local", "--from", "x"},
        {"ws://a:1", "--bench", "2", "--from", "scene"}, // which --local alone answers from
        {"ws://a:1", "--at", "1,2", "--points", "x.csv"},
        {"ws://a:1", "--at", "1,2", "--bench", "5"},
        {"ws://a:1", "--bench", "0"},
        {"ws://a:1", "--at", "1,2", "--ca-file", "c.pem"}, // no certificate would be looked at
        {"ws://a:1", "--bench", "10", "--watch", "3"},
        {"ws://a:1", "--bench", "10", "--time", "5"},
        {"ws://a:1", "--at", "1,2", "--watch", "-1"},
        {"ws://a:1", "--at", "1,2", "--watch", "0"},
        {"ws://a:1", "--at", "1,2", "--watch", "nan"},
        {"ws://a:1", "--at", "1,2", "--watch", "1e-12"},
        {"ws://a:1", "--at", "1,2", "--watch", "1001"},
        {"ws://a:1", "--at", "1,2", "--token-file", ""},
        {"ws://a:1", "--at", "1,2", "--format", "xml"},
        {"ws://a:1", "--at", "1,2", "--timeout", "nan"},
        {"ws://a:1", "--at", "1,2", "--local", "--size-max", "64"},
        {"ws://a:1", "--at", "1,2", "--local", "--watch", "1", "--size-max", "31"},
        {"ws://a:1", "--at", "1,2", "--local", "--watch", "1", "--rate-max", "0.9"},
        {"ws://a:1", "--at", "1,2", "--watch", "1", "--rate-max", "2"},
        {"ws://a:1", "--at", "1,2", "--local", "--z", "-1"},
        {"ws://a:1", "--bench", "2", "--z", "-1"},
        {"ws://a:1", "--bench", "2", "--min-wavelength", "3"},
        {"ws://a:1", "--at", "1,2", "--bogus"}};
    for (const auto& arguments : wrong) {
        const auto read = query_options_of(arguments);
        ASSERT_TRUE(std::holds_alternative<int>(read)) << arguments.back();
        EXPECT_EQ(std::get<int>(read), exit_usage);
    }
}

sea::Answer some_answer() {
    sea::Answer answer;
    answer.height_m = 0.1 + 0.2;
    answer.normal[0] = -1.0 / 3.0;
    answer.error_m = 0.01f;
    answer.flags = sea::answer_folded | sea::answer_exact;
    return answer;
}

TEST(Output, csv_and_json_give_back_every_double_as_it_was) {
    const sea::QueryPoint point{1e6 + 1.0 / 3.0, -0.0, 946'728'000'000'001};
    const sea::Answer answer = some_answer();
    const auto json =
        nlohmann::json::parse(output_rows(Format::json, {&point, 1}, {&answer, 1}, false));
    ASSERT_EQ(json.size(), 1u);
    EXPECT_EQ(json[0]["x_m"].get<double>(), point.x_m);
    EXPECT_EQ(json[0]["t_s"].get<double>(), 946728000.000001);
    EXPECT_EQ(json[0]["height_m"].get<double>(), answer.height_m);
    EXPECT_EQ(json[0]["error_m"].get<double>(), answer.error_m);
    EXPECT_EQ(json[0]["flags"].get<unsigned>(), 17u);

    const std::string csv = output_rows(Format::csv, {&point, 1}, {&answer, 1}, false);
    std::istringstream fields(csv);
    std::vector<std::string> values;
    for (std::string field; std::getline(fields, field, ',');)
        values.push_back(field);
    ASSERT_EQ(values.size(), 12u);
    EXPECT_EQ(std::stod(values[0]), point.x_m);
    EXPECT_EQ(std::stod(values[3]), answer.height_m);
    EXPECT_EQ(std::stod(values[4]), answer.normal[0]);
    EXPECT_EQ(values[11], "17\n");
}

TEST(Output, columns_are_the_public_contract) {
    EXPECT_EQ(output_head(Format::csv),
              "x_m,y_m,t_s,height_m,normal_x,normal_y,normal_z,velocity_x_mps,velocity_y_mps,"
              "velocity_z_mps,error_m,flags\n");
}

Output run_query(const std::string& arguments) {
    return tests::run_program("seaway-query", arguments);
}

/// Stopped once it has said so many lines and, from then on, so much time has passed.
Output run_until_lines(int lines, const std::string& arguments, int further_s = 0) {
    const std::string said = tests::folder().fresh("said");
    std::ofstream{said}; // empty, before anybody counts its lines
    return run_query(fmt::format("{0} >{1} & until [ $(wc -l <{1}) -ge {2} ] || ! kill -0 $!; do "
                                 "sleep 0.02; done; sleep {3}; "
                                 "kill -TERM $!; wait $!; ended=$?; cat {1}; exit $ended",
                                 arguments, said, lines, further_s));
}

class Program : public tests::WaveServer {
  protected:
    nlohmann::json rows(const std::string& arguments) {
        const Output outcome = run_query(net->url() + " --format json " + arguments);
        EXPECT_EQ(outcome.status, 0) << arguments;
        return nlohmann::json::parse(outcome.out, nullptr, false);
    }
};

TEST_F(Program, answers_by_server_by_itself_and_exactly_agree) {
    const std::string where = "--at -12.5,40 3e4,-7 --time 1234.5678";
    const auto served = rows(where);
    const auto local = rows(where + " --local");
    const auto exact = rows(where + " --exact");
    ASSERT_EQ(served.size(), 2u);
    ASSERT_EQ(local.size(), 2u);
    ASSERT_EQ(exact.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(exact[i]["t_s"].get<double>(), 1234.5678);
        EXPECT_EQ(exact[i]["flags"].get<unsigned>(), 16u);
        EXPECT_EQ(served[i]["height_m"], exact[i]["height_m"]);
        EXPECT_NEAR(local[i]["height_m"].get<double>(), exact[i]["height_m"].get<double>(),
                    local[i]["error_m"].get<double>());
    }
}

// The second cascade begins at 20 m.
TEST_F(Program, leaves_out_what_a_hull_does_not_feel_whoever_answers) {
    const std::string where = "--at -12.5,40 3e4,-7 --time 1234.5678 --min-wavelength ";
    const sea::QueryPoint points[] = {{-12.5, 40, 1'234'567'800}, {3e4, -7, 1'234'567'800}};
    for (const auto& [shortest_m, felt] : {std::pair{"19.9", 3u}, {"20.1", 1u}})
        for (const std::string way : {"", " --local", " --exact"}) {
            const auto answered = rows(where + shortest_m + way);
            ASSERT_EQ(answered.size(), 2u);
            for (std::size_t i = 0; i < 2; ++i) {
                sea::WaterBelow unused;
                EXPECT_NEAR(answered[i]["height_m"].get<double>(),
                            sea.truth(points[i], felt, 0, unused).height_m,
                            answered[i]["error_m"].get<double>())
                    << shortest_m << way;
                EXPECT_LT(answered[i]["error_m"].get<double>(), 0.01) << "else both would do";
            }
        }
    const auto many = rows("--points - --local --min-wavelength 20.1 "
                           "<<END\n$(seq 1 60 | sed 's/.*/&,&,&/')\nEND\n");
    ASSERT_EQ(many.size(), 60u) << "times that are not held at once";
    for (std::size_t i = 0; i < 60; ++i) {
        const double n = static_cast<double>(i + 1);
        sea::WaterBelow unused;
        EXPECT_NEAR(many[i]["height_m"].get<double>(),
                    sea.truth({n, n, sea::us_from_seconds(n)}, 1u, 0, unused).height_m,
                    many[i]["error_m"].get<double>());
    }
}

TEST_F(Program, dives) {
    const sea::QueryPoint points[] = {{-12.5, 40, 50'000'000}, {3, 4, 50'000'000}};
    for (const std::string felt : {"", " --min-wavelength 20.1"})
        for (const double z_m : {-3.5, 9.0}) { // waves are 1.2 m high at most
            const auto answered =
                rows("--at -12.5,40 3,4 --time 50 --z " + fmt::format("{}", z_m) + felt);
            ASSERT_EQ(answered.size(), 2u);
            for (std::size_t i = 0; i < 2; ++i) {
                sea::WaterBelow water;
                const sea::Answer truth = sea.truth(points[i], felt.empty() ? 3u : 1u, z_m, water);
                EXPECT_EQ(answered[i]["z_m"].get<double>(), z_m);
                EXPECT_EQ(answered[i]["surface_m"].get<double>(), truth.height_m);
                // Floats on the wire.
                EXPECT_FLOAT_EQ(answered[i]["velocity_z_mps"].get<float>(),
                                static_cast<float>(water.velocity_mps[2]));
                EXPECT_FLOAT_EQ(answered[i]["pressure_m2ps2"].get<float>(),
                                static_cast<float>(water.pressure_m2ps2));
                EXPECT_EQ((answered[i]["flags"].get<unsigned>() & sea::answer_dry) != 0, z_m > 0);
                EXPECT_EQ(water.pressure_m2ps2 == 0, z_m > 0);
            }
        }
    sea.knows_below = false;
    EXPECT_EQ(run_query(net->url() + " --at 0,0 --z -1").status, 6) << "a server that is older";
}

TEST_F(Program, reads_points_with_times_of_their_own) {
    const auto answered = rows("--points - --time 50 <<END\nx_m,y_m,t_s\n1,2,30\n3,4\nEND\n");
    ASSERT_EQ(answered.size(), 2u);
    EXPECT_EQ(answered[0]["t_s"].get<double>(), 30);
    EXPECT_EQ(answered[1]["t_s"].get<double>(), 50);
    EXPECT_EQ(answered[1]["height_m"].get<double>(), sea.truth({3, 4, 50'000'000}).height_m);
}

TEST_F(Program, every_time_that_may_be_asked_for_is_answered_by_the_server_and_locally) {
    for (const char* time_s : {"1e12", "-1e12"})
        for (const char* way : {"", " --local"}) {
            const auto answered = rows("--at 3,4 --time " + std::string(time_s) + way);
            ASSERT_EQ(answered.size(), 1u);
            EXPECT_EQ(answered[0]["t_s"].get<double>(), std::stod(time_s));
            const double truth_m =
                sea.truth({3, 4, sea::us_from_seconds(std::stod(time_s))}).height_m;
            EXPECT_NEAR(answered[0]["height_m"].get<double>(), truth_m,
                        answered[0]["error_m"].get<double>());
        }
}

TEST_F(Program, now_is_the_sea_time_of_the_server) {
    const double before_s = sea::seconds_from_us(sea.sea_time_us());
    const auto answered = rows("--at 0,0");
    const double after_s = sea::seconds_from_us(sea.sea_time_us());
    // Half of the connection's first round trip is all that a loopback clock can be wrong by.
    EXPECT_GT(answered[0]["t_s"].get<double>(), before_s - 1);
    EXPECT_LT(answered[0]["t_s"].get<double>(), after_s + 1);
}

TEST_F(Program, watches_until_it_is_stopped) {
    const Output outcome =
        run_until_lines(3, net->url() + " --at 0,0 --local --watch 20 --format csv");
    EXPECT_EQ(outcome.status, 0);
    std::istringstream lines(outcome.out);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line + "\n", output_head(Format::csv));
    double last_s = -1;
    int rows_seen = 0;
    while (std::getline(lines, line)) {
        std::istringstream fields(line);
        std::string field;
        for (int i = 0; i < 3; ++i)
            std::getline(fields, field, ',');
        EXPECT_GT(std::stod(field), last_s);
        last_s = std::stod(field);
        ++rows_seen;
    }
    EXPECT_GE(rows_seen, 2);
}

// As a clock does that was set to the time given when the first answer came.
TEST_F(Program, watched_times_that_were_given_move_on_with_the_clock) {
    const auto start = std::chrono::steady_clock::now();
    const Output outcome =
        run_until_lines(4, net->url() + " --at 0,0 --time -3600 --watch 20 --format csv");
    const std::chrono::duration<double> ran = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(outcome.status, 0);
    std::istringstream lines(outcome.out);
    std::vector<double> times_s;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream fields(line);
        std::string field;
        for (int i = 0; i < 3; ++i)
            std::getline(fields, field, ',');
        if (field != "t_s")
            times_s.push_back(std::stod(field));
    }
    ASSERT_GE(times_s.size(), 2u);
    EXPECT_GE(times_s.front(), -3600);
    for (std::size_t i = 1; i < times_s.size(); ++i)
        EXPECT_GT(times_s[i], times_s[i - 1]);
    EXPECT_LE(times_s.back(), -3600 + ran.count());
}

TEST_F(Program, fails_with_one_line_and_the_documented_exit_code) {
    const std::string url = net->url();
    const std::pair<std::string, int> cases[] = {
        {url + " --at 1", 2},
        {url + " --points /no/such/file.csv", 2},
        {url + "/nowhere --at 0,0", 5},
        {"ws://127.0.0.1:1 --at 0,0", 5},
        {url + " --at 0,0 --token-file /no/such/file", 2},
        {url + " --at 0,0 --time 1.001e12", 2},
        {url + " --at 0,0 --local --time -9.2e12", 2},
    };
    for (const auto& [arguments, code] : cases) {
        const Output outcome = run_query(arguments);
        EXPECT_EQ(outcome.status, code) << arguments;
        EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
        EXPECT_EQ(outcome.err.rfind("seaway-query: ", 0), 0u) << outcome.err;
    }
    sea.offered = sea::FieldSet{};
    EXPECT_EQ(run_query(url + " --at 0,0 --local --watch 1").status, 6);
    sea.offered =
        sea::FieldSet{sea::Field::height}; // of which no height between points can be made
    EXPECT_EQ(run_query(url + " --at 0,0 --local").status, 6);
    sea.answer_queries = false;
    EXPECT_EQ(run_query(url + " --at 0,0 --timeout 0.3").status, 5);
}

// Naive: a beat is waited for, and the next is written into nothing, for ever.
TEST_F(Program, a_full_disk_behind_standard_output_ends_it) {
    for (const char* way : {" --at 0,0", " --at 0,0 --watch 5", " --at 0,0 --watch 5 --local",
                            " --bench 4 --local", " --help"}) {
        const Output outcome = run_query(net->url() + way + " >/dev/full");
        EXPECT_EQ(outcome.status, exit_output) << way;
        EXPECT_EQ(outcome.err, "seaway-query: cannot write to standard output: what was printed is "
                               "lost\n")
            << way;
    }
}

// A pipe that stays open and says nothing: the points never end. Killed after 10 s, it would be 137.
TEST_F(Program, a_signal_ends_it_while_it_reads_points) {
    const Output outcome = run_query(
        "--version >/dev/null; mkfifo " + tests::folder().file("points") +
        "; timeout -k 10 100 " SEAWAY_BIN_DIR "/seaway-query " + net->url() + " --points - <>" +
        tests::folder().file("points") + " & sleep 1; kill -TERM $!; wait $!");
    EXPECT_EQ(outcome.status, 128 + SIGTERM);
}

TEST_F(Program, its_help_names_each_source) {
    const Output outcome = run_query("--help");
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.out.find("--from tiles|spectrum|scene"), std::string::npos) << outcome.out;
}

// As client/seaway.h has them.
TEST_F(Program, its_help_says_which_flags_leave_no_bound) {
    const std::string help = run_query("--help").out;
    for (const char* says :
         {"1 folded (the highest sheet),", "2 not converged (error_m covers it),",
          "4 extrapolated (error_m is no bound)",
          "64 open (which of two sheets is the highest; error_m is no bound)"})
        EXPECT_NE(help.find(says), std::string::npos) << says;
}

// Naive: 1e12 s in nanoseconds is no number of them, and every beat is over already.
TEST_F(Program, the_slowest_watch_waits_for_its_second_beat) {
    const Output outcome =
        run_until_lines(2, net->url() + " --at 0,0 --watch 1e-5 --format csv", 1);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 2) << "a head and a row";
}

TEST_F(Program, shows_what_is_no_text_as_numbers) {
    const Output outcome =
        run_query(net->url() + " --points - <<END\n$(printf '\\033[2J\\377,1')\nEND\n");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("x_m = '\\x1b[2J\\xff'"), std::string::npos) << outcome.err;
}

// One array of two points an answer: a line of it while it is watched, else a line a point.
TEST_F(Program, json_is_one_line_an_answer_while_it_is_watched) {
    const std::string where = net->url() + " --at 1,2 3,4 --format json";
    const Output once = run_query(where);
    EXPECT_EQ(std::count(once.out.begin(), once.out.end(), '\n'), 2) << once.out;
    const Output watched = run_until_lines(1, where + " --watch 1e-5", 1);
    EXPECT_EQ(std::count(watched.out.begin(), watched.out.end(), '\n'), 1) << watched.out;
    EXPECT_EQ(nlohmann::json::parse(watched.out, nullptr, false).size(), 2u);
}

TEST_F(Program, measures_rates_both_ways) {
    for (const char* way : {"--bench 64 --exact", "--bench 64 --local"}) {
        const auto measured = rows(way);
        const std::vector<int> in_flight =
            std::string(way).ends_with("local") ? std::vector{1} : std::vector{1, 8};
        ASSERT_EQ(measured.size(), in_flight.size()) << way;
        for (std::size_t i = 0; i < in_flight.size(); ++i)
            EXPECT_EQ(measured[i]["in_flight"].get<int>(), in_flight[i]);
        for (const auto& row : measured) {
            EXPECT_EQ(row["points_per_query"].get<int>(), 64);
            EXPECT_GT(row["queries"].get<int>(), 0);
            EXPECT_GT(row["points_per_s"].get<double>(), 0);
            const double p50_ms = row["round_trip_p50_ms"], p99_ms = row["round_trip_p99_ms"];
            EXPECT_LE(p50_ms, p99_ms);
            if (row["queries"].get<int>() > 200) { // no clock is so coarse
                EXPECT_LT(p50_ms, p99_ms);
            }
            EXPECT_EQ(row["how"], std::string(way).ends_with("local") ? "local" : "exact");
        }
    }
    EXPECT_GT(sea.queries, 0);
    EXPECT_EQ(sea.exact_queries, sea.queries);
}

} // namespace
} // namespace seaway::client
