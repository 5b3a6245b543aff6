// SPDX-License-Identifier: Apache-2.0
// What seaway-query prints and takes: every column of every format, every option away from its default,
// every number at its limits. No two values are equal.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <utility>
#include <variant>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/apps/query_options.h"
#include "client/apps/query_output.h"
#include "client/apps/query_run.h"
#include "tests/client/query_options_of.h"
#include "tests/support/lines_of.h"

namespace seaway::client {
namespace {

using nlohmann::json;

constexpr const char* columns[] = {"x_m",
                                   "y_m",
                                   "t_s",
                                   "height_m",
                                   "normal_x",
                                   "normal_y",
                                   "normal_z",
                                   "velocity_x_mps",
                                   "velocity_y_mps",
                                   "velocity_z_mps",
                                   "error_m"};
/// In the order of `columns`, one row each; exact in few binary digits.
constexpr double rows[2][11] = {
    {-12.5, 40.25, 1234.75, -1.125, -0.25, 0.375, 0.875, 1.5, -2.25, 0.625, 0.03125},
    {3.5, -7.75, -50.5, 2.0625, 0.125, -0.5, 0.75, -3.25, 4.5, -0.0625, 0.015625}};
constexpr std::uint32_t flags[2] = {17, 34};

std::vector<sea::QueryPoint> points() {
    std::vector<sea::QueryPoint> made;
    for (const auto& row : rows)
        made.push_back({row[0], row[1], std::llround(row[2] * 1e6)});
    return made;
}
std::vector<sea::Answer> answers() {
    std::vector<sea::Answer> made;
    for (std::size_t i = 0; i < 2; ++i) {
        const auto& r = rows[i];
        made.push_back({.height_m = r[3],
                        .normal = {r[4], r[5], r[6]},
                        .velocity_mps = {r[7], r[8], r[9]},
                        .error_m = r[10],
                        .flags = flags[i]});
    }
    return made;
}
std::vector<std::string> words_of(std::string line) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream in(line);
    return {std::istream_iterator<std::string>(in), {}};
}

TEST(QueryOutput, every_column_of_every_format_holds_what_it_is_called_by) {
    for (const bool compact : {false, true}) {
        const std::string text = output_rows(Format::json, points(), answers(), compact);
        EXPECT_EQ(tests::lines_of(text).size(), compact ? 1u : 2u) << text;
        const json shown = json::parse(text);
        ASSERT_EQ(shown.size(), 2u);
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(shown[i].size(), 12u);
            for (std::size_t c = 0; c < 11; ++c)
                EXPECT_EQ(shown[i][columns[c]].get<double>(), rows[i][c]) << columns[c];
            EXPECT_EQ(shown[i]["flags"].get<unsigned>(), flags[i]);
        }
    }
    const auto head = words_of(output_head(Format::csv));
    const auto csv = tests::lines_of(output_rows(Format::csv, points(), answers(), false));
    ASSERT_EQ(csv.size(), 2u);
    // A table has a line of titles, columns in the same order and flags by name.
    EXPECT_EQ(output_head(Format::table) + output_head(Format::json), "");
    const auto table = tests::lines_of(output_rows(Format::table, points(), answers(), false));
    ASSERT_EQ(table.size(), 3u);
    EXPECT_EQ(words_of(table[0]).size(), 12u);
    const char* const named[] = {"folded exact", "not_converged vertical_velocity"};
    for (std::size_t i = 0; i < 2; ++i) {
        const auto values = words_of(csv[i]), cells = words_of(table[i + 1]);
        ASSERT_EQ(values.size(), 12u);
        ASSERT_EQ(cells.size(), 13u);
        for (std::size_t c = 0; c < 11; ++c) {
            EXPECT_EQ(head[c], columns[c]);
            EXPECT_EQ(std::stod(values[c]), rows[i][c]) << columns[c];
            EXPECT_NEAR(std::stod(cells[c]), rows[i][c], 5.1e-4) << columns[c]; // three decimals
        }
        EXPECT_EQ(values[11], std::to_string(flags[i]));
        EXPECT_EQ(cells[11] + " " + cells[12], named[i]);
    }
}

TEST(QueryOutput, every_column_of_water_below_holds_what_it_is_called_by) {
    const char* const names[] = {"x_m",
                                 "y_m",
                                 "t_s",
                                 "z_m",
                                 "surface_m",
                                 "velocity_x_mps",
                                 "velocity_y_mps",
                                 "velocity_z_mps",
                                 "pressure_m2ps2"};
    Below found{answers(), {{{6.5, -7.25, 8.125}, 9.0625}, {{-10.5, 11.25, -12.125}, -13.0625}}};
    const json shown = json::parse(output_rows(Format::json, points(), -3.75, found, true));
    const auto head = words_of(output_head(Format::csv, true));
    const auto csv = tests::lines_of(output_rows(Format::csv, points(), -3.75, found, false));
    const auto table = tests::lines_of(output_rows(Format::table, points(), -3.75, found, false));
    EXPECT_EQ(output_head(Format::table, true) + output_head(Format::json, true), "");
    ASSERT_EQ(shown.size(), 2u);
    ASSERT_EQ(csv.size(), 2u);
    ASSERT_EQ(table.size(), 3u);
    ASSERT_EQ(head.size(), 10u);
    EXPECT_EQ(words_of(table[0]).size(), 10u);
    for (std::size_t i = 0; i < 2; ++i) {
        const auto& r = rows[i];
        const auto& water = found.water[i];
        const double held[] = {r[0],
                               r[1],
                               r[2],
                               -3.75,
                               r[3],
                               water.velocity_mps[0],
                               water.velocity_mps[1],
                               water.velocity_mps[2],
                               water.pressure_m2ps2};
        const auto values = words_of(csv[i]), cells = words_of(table[i + 1]);
        ASSERT_EQ(values.size(), 10u);
        for (std::size_t c = 0; c < 9; ++c) {
            EXPECT_EQ(head[c], names[c]);
            EXPECT_EQ(shown[i][names[c]].get<double>(), held[c]) << names[c];
            EXPECT_EQ(std::stod(values[c]), held[c]) << names[c];
            EXPECT_NEAR(std::stod(cells[c]), held[c], 5.1e-4) << names[c]; // three decimals
        }
        EXPECT_EQ(shown[i]["flags"].get<unsigned>(), flags[i]);
        EXPECT_EQ(values[9], std::to_string(flags[i]));
    }
}

TEST(QueryOutput, every_flag_has_its_own_name) {
    const char* const names[] = {"folded", "not_converged",     "extrapolated", "invalid",
                                 "exact",  "vertical_velocity", "open",         "stale",
                                 "dry",    "foam_late"};
    for (std::uint32_t bit = 0; bit < std::size(names); ++bit)
        EXPECT_EQ(flag_names(1u << bit), names[bit]);
}

TEST(QueryOutput, every_column_of_a_measurement_holds_what_it_is_called_by) {
    const std::vector<BenchRow> measured{{"server", 64, 8, 1000, 2.5, 0.75, 3.25},
                                         {"exact", 32, 1, 500, 1.25, 1.75, 2.5}};
    const char* const names[] = {"points_per_query", "in_flight",    "queries",
                                 "seconds",          "points_per_s", "round_trip_p50_ms",
                                 "round_trip_p99_ms"};
    const double values[2][7] = {{64, 8, 1000, 2.5, 25600, 0.75, 3.25},
                                 {32, 1, 500, 1.25, 12800, 1.75, 2.5}};
    const json shown = json::parse(output_bench(Format::json, measured));
    const auto csv = tests::lines_of(output_bench(Format::csv, measured));
    const auto table = tests::lines_of(output_bench(Format::table, measured));
    ASSERT_EQ(shown.size(), 2u);
    ASSERT_EQ(csv.size(), 3u);
    ASSERT_EQ(table.size(), 3u);
    EXPECT_EQ(words_of(csv[0]), words_of(table[0]));
    for (std::size_t i = 0; i < 2; ++i) {
        const auto line = words_of(csv[i + 1]), cells = words_of(table[i + 1]);
        ASSERT_EQ(line.size(), 8u);
        ASSERT_EQ(cells.size(), 8u);
        EXPECT_EQ(shown[i]["how"], measured[i].how);
        EXPECT_EQ(line[0], measured[i].how);
        EXPECT_EQ(cells[0], measured[i].how);
        for (std::size_t c = 0; c < 7; ++c) {
            EXPECT_EQ(words_of(csv[0])[c + 1], names[c]);
            EXPECT_EQ(shown[i][names[c]].get<double>(), values[i][c]) << names[c];
            EXPECT_EQ(std::stod(line[c + 1]), values[i][c]) << names[c];
            EXPECT_NEAR(std::stod(cells[c + 1]), values[i][c], 0.0051) << names[c]; // two decimals
        }
    }
}

// Naive: beats are counted, and each try in vain, ten a second, counts as one: after an outage of a minute nothing is asked for many.
TEST(QueryRun, a_watch_goes_on_with_the_next_beat_however_often_it_has_tried) {
    EXPECT_EQ(next_beat_s(0.0, 2), 0.5);
    EXPECT_EQ(next_beat_s(0.49, 2), 0.5);
    EXPECT_EQ(next_beat_s(0.5, 2), 1.0);
    EXPECT_EQ(next_beat_s(61.3, 1), 62.0);
    EXPECT_EQ(next_beat_s(61.3, 0.1), 70.0);
}

// Naive: the same places at the time at which it began, so that each call finds what the one before has put into some memory.
TEST(QueryRun, a_bench_asks_about_other_places_and_about_now_in_each_call) {
    constexpr int calls = 10, points_each = 7;
    BenchPoints drawn(points_each);
    std::set<sea::TimeUs> times_us;
    std::set<std::pair<double, double>> places;
    for (int call = 1; call <= calls; ++call)
        for (const sea::QueryPoint& point : drawn.next(1000 * call)) {
            EXPECT_EQ(point.time_us, 1000 * call);
            times_us.insert(point.time_us);
            places.insert({point.x_m, point.y_m});
            EXPECT_LE(std::max(std::abs(point.x_m), std::abs(point.y_m)), 10e3);
        }
    EXPECT_EQ(times_us.size(), std::size_t{calls});
    EXPECT_EQ(places.size(), std::size_t{calls * points_each});
}

TEST(QueryOptions, each_goes_where_it_says_and_has_its_default) {
    const auto taken = [](std::vector<const char*> words) {
        const auto read = query_options_of(std::move(words));
        EXPECT_TRUE(std::holds_alternative<QueryOptions>(read));
        return std::holds_alternative<QueryOptions>(read) ? std::get<QueryOptions>(read)
                                                          : QueryOptions{};
    };
    const QueryOptions plain = taken({"ws://a:1", "--points", "p.csv"});
    EXPECT_EQ(plain.url, "ws://a:1");
    EXPECT_EQ(plain.points_file, "p.csv");
    EXPECT_TRUE(plain.at.empty());
    EXPECT_FALSE(plain.time_s || plain.exact || plain.local);
    EXPECT_EQ(plain.format, Format::table);
    EXPECT_EQ(plain.min_wavelength_m, 0);
    EXPECT_FALSE(plain.z_m);
    EXPECT_EQ(plain.watch_hz, 0);
    EXPECT_EQ(plain.bench_points, 0);
    EXPECT_EQ(plain.timeout_s, 10);
    EXPECT_EQ(plain.token_file + plain.ca_file, "");
    const QueryOptions all =
        taken({"wss://a:1", "--at", "1,-2", "3,4", "--time", "5.5", "--local", "--format", "json",
               "--watch", "0.25", "--min-wavelength", "12.5", "--timeout", "7.5", "--token-file",
               "t", "--ca-file", "c"});
    ASSERT_EQ(all.at.size(), 2u);
    EXPECT_EQ(all.at[0].x_m, 1);
    EXPECT_EQ(all.at[0].y_m, -2);
    EXPECT_EQ(all.at[1].x_m, 3);
    EXPECT_EQ(all.at[1].y_m, 4);
    EXPECT_EQ(all.time_s, 5.5);
    EXPECT_TRUE(all.local);
    EXPECT_FALSE(all.exact);
    EXPECT_EQ(all.format, Format::json);
    EXPECT_EQ(all.watch_hz, 0.25);
    EXPECT_EQ(all.min_wavelength_m, 12.5);
    EXPECT_EQ(all.timeout_s, 7.5);
    EXPECT_EQ(all.token_file, "t");
    EXPECT_EQ(all.ca_file, "c");
    EXPECT_EQ(taken({"ws://a:1", "--at", "1,2", "--z", "-7.25"}).z_m, -7.25);
    EXPECT_EQ(taken({"ws://a:1", "--at", "1,2", "--z=0"}).z_m, 0);
    const QueryOptions bench = taken({"ws://a:1", "--bench", "33", "--exact", "--format", "csv"});
    EXPECT_EQ(bench.bench_points, 33);
    EXPECT_TRUE(bench.exact);
    EXPECT_EQ(bench.format, Format::csv);
    EXPECT_EQ(taken({"ws://a:1", "--at", "1,2", "--format", "table"}).format, Format::table);
}

TEST(QueryOptions, each_number_is_taken_up_to_its_limits_and_no_further) {
    struct Limits {
        const char* option;
        std::vector<const char*> within, beyond;
    };
    for (const Limits& row :
         {Limits{"--time", {"1e12", "-1e12", "now"}, {"1.001e12", "-1.001e12", "nan", "inf"}},
          {"--watch", {"1e-5", "1000"}, {"9e-6", "1000.5", "-1", "inf"}},
          {"--min-wavelength", {"0", "1e9"}, {"-1", "1.001e9", "nan", "inf"}},
          {"--z", {"-1e9", "1e9"}, {"-1.001e9", "1.001e9", "nan", "inf", "deep"}},
          {"--timeout", {"86400", "1e-3"}, {"86401", "0", "-1", "inf"}}}) {
        for (const char* value : row.within)
            EXPECT_EQ(query_options_of({"ws://a:1", "--at", "1,2", row.option, value}).index(), 0u)
                << row.option << ' ' << value;
        for (const char* value : row.beyond)
            EXPECT_EQ(query_options_of({"ws://a:1", "--at", "1,2", row.option, value}).index(), 1u)
                << row.option << ' ' << value;
    }
    for (const auto& [points, fine] :
         {std::pair("1", true), {"1000000", true}, {"0", false}, {"1000001", false}})
        EXPECT_EQ(query_options_of({"ws://a:1", "--bench", points}).index() == 0, fine) << points;
    for (const auto& [place, fine] : {std::pair("1e9,-1e9", true),
                                      {"-1e9,1e9", true},
                                      {"1.1e9,0", false},
                                      {"0,-1.1e9", false}}) {
        EXPECT_EQ(parse_place(place).has_value(), fine) << place;
        std::istringstream rows_in(std::string(place) + ",1e12\n");
        EXPECT_EQ(read_places(rows_in, "p").has_value(), fine) << place;
    }
    for (const auto& [time_s, fine] :
         {std::pair("1e12", true), {"-1e12", true}, {"1.1e12", false}, {"-1.1e12", false}}) {
        std::istringstream rows_in(std::string("0,0,") + time_s);
        EXPECT_EQ(read_places(rows_in, "p").has_value(), fine) << time_s;
    }
}

// A wrong row is named by its line of the file, whatever is blank before it.
TEST(QueryPoints, a_line_is_counted_though_it_is_blank_or_the_header) {
    std::istringstream in("x_m,y_m\n\n1,2\n  \n\n3\n");
    const auto places = read_places(in, "points.csv");
    ASSERT_FALSE(places);
    EXPECT_EQ(places.error().message.find("points.csv:6: "), 0u) << places.error().message;
}

// Naive: three bytes that nobody sees, of a spreadsheet's "CSV UTF-8", stand before the first title.
TEST(QueryPoints, a_file_may_begin_with_the_mark_of_utf_8) {
    for (const char* text : {"\xef\xbb\xbfx_m,y_m\n1,2\n", "\xef\xbb\xbf"
                                                           "1,2\n"}) {
        std::istringstream in(text);
        const auto places = read_places(in, "p.csv");
        ASSERT_TRUE(places) << places.error().message;
        ASSERT_EQ(places->size(), 1u);
        EXPECT_EQ(places->front().x_m, 1);
    }
}

// Naive: a line goes on for as long as its file does, in memory.
TEST(QueryPoints, a_line_and_a_file_have_an_end) {
    std::istringstream line("1,2\n" + std::string(csv_line_bytes_max, ' ') + "\n3,4" +
                            std::string(csv_line_bytes_max - 2, ' ') + "\n");
    const auto longer = read_places(line, "p.csv");
    ASSERT_FALSE(longer);
    EXPECT_EQ(longer.error().message, "p.csv:3: the line has more than 4096 bytes");
    std::istringstream three("x_m,y_m\n1,2\n3,4\n\n5,6\n"), two("x_m,y_m\n1,2\n3,4");
    const auto more = read_places(three, "p.csv", 2);
    ASSERT_FALSE(more);
    EXPECT_EQ(more.error().message, "p.csv:5: more than 2 points");
    EXPECT_EQ(read_places(two, "p.csv", 2).value().size(), 2u);
}

TEST(Output, what_is_not_a_number_is_null_in_json) {
    const sea::QueryPoint point{std::numeric_limits<double>::quiet_NaN(), 0, 0};
    sea::Answer answer;
    answer.height_m = std::numeric_limits<double>::quiet_NaN();
    answer.error_m = std::numeric_limits<double>::infinity();
    const auto json =
        nlohmann::json::parse(output_rows(Format::json, {&point, 1}, {&answer, 1}, true));
    EXPECT_TRUE(json[0]["x_m"].is_null());
    EXPECT_TRUE(json[0]["height_m"].is_null());
    EXPECT_TRUE(json[0]["error_m"].is_null());
}

TEST(Output, flags_have_names_for_people) {
    EXPECT_EQ(flag_names(0), "-");
    EXPECT_EQ(flag_names(sea::answer_vertical_velocity), "vertical_velocity");
    EXPECT_EQ(flag_names(sea::answer_folded | sea::answer_exact), "folded exact");
    EXPECT_EQ(
        flag_names(sea::answer_not_converged | sea::answer_extrapolated | sea::answer_invalid),
        "not_converged extrapolated invalid");
    EXPECT_EQ(flag_names(sea::answer_folded | sea::answer_vertical_velocity | sea::answer_open),
              "folded vertical_velocity open");
}

} // namespace
} // namespace seaway::client
