// SPDX-License-Identifier: Apache-2.0
// A freighter that rides the sea of a running server for ten minutes: heave, roll and pitch as a table and as a plot.
//
//     c++ -O2 ship.cpp $(pkg-config --cflags --libs seaway) -o ship
//     ./ship ws://127.0.0.1:9430 [ship.csv [ship.svg [SECONDS]]]
//
// It has the waves of the sea sent, once, and then goes on as fast as it can: ten minutes of sea take some 20 seconds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <seaway/buoyancy.h>
#include <seaway/seaway.hpp>

#include "freighter.h"

namespace {

constexpr double step_s = 0.1;
constexpr double degrees = 180 / 3.14159265358979323846;
constexpr double head_rad = 2.6; ///< the bow, anticlockwise from east: into the wind of the gale

struct Row {
    double time_s;
    double heave_m; ///< of the centre of mass, from where it is afloat in still water
    double roll_deg;
    double pitch_deg;
    double water_m; ///< mean of the water above the hull's corners
};

/// Roll to starboard and bow down are positive, as turns about the axes ahead and to port.
Row row_of(const seaway_body& body, const std::vector<seaway_answer>& water, double time_s) {
    double rows[3][3];
    seaway_rows(body.orientation, rows);
    double mean_m = 0;
    for (const seaway_answer& one : water)
        mean_m += one.height_m / static_cast<double>(water.size());
    return {time_s, body.position_m[2] - Freighter::afloat_m,
            degrees * std::atan2(rows[2][1], rows[2][2]), -degrees * std::asin(rows[2][0]), mean_m};
}

/// The helmsman: rudder and engine keep the bow where it is.
void steer(seaway_body& body) {
    double rows[3][3];
    seaway_rows(body.orientation, rows);
    const double off_rad = std::remainder(head_rad - std::atan2(rows[1][0], rows[0][0]), 2 * M_PI);
    body.angular_velocity_radps[2] +=
        step_s * (0.01 * off_rad - 0.2 * body.angular_velocity_radps[2]);
}

std::vector<Row> sail(seaway::Sea& sea, double seconds) {
    seaway_subscription waves{};
    waves.rung = SEAWAY_SPECTRUM;
    sea.subscribe(waves);
    const Freighter ship;
    const seaway_hull& hull = ship.hull();
    if (const char* fault = seaway_hull_fault(&hull))
        throw std::runtime_error(fault);
    seaway_body body{{0, 0, Freighter::afloat_m},
                     {std::cos(head_rad / 2), 0, 0, std::sin(head_rad / 2)},
                     {0, 0, 0},
                     {0, 0, 0}};
    std::vector<seaway_point> points(hull.vertex_count);
    std::vector<seaway_answer> answers(hull.vertex_count);
    std::vector<Row> rows;
    const int64_t begin_us = sea.now_us();
    for (int i = 0; i * step_s < seconds; ++i) {
        const int64_t time_us = begin_us + static_cast<int64_t>(std::llround(1e6 * step_s * i));
        seaway_hull_points(&hull, &body, time_us, points.data());
        const seaway_code code =
            seaway_sample(sea.handle(), points.data(), points.size(), answers.data());
        if (code != SEAWAY_OK)
            throw seaway::SeaError(code);
        rows.push_back(row_of(body, answers, step_s * i));
        if (seaway_hull_step(&hull, &body, points.data(), answers.data(), step_s) != SEAWAY_OK)
            throw std::runtime_error("the hull takes no such step");
        steer(body);
    }
    return rows;
}

/// Also what is still on its way to the disk.
void finish(std::ofstream& file, const std::string& path) {
    file.close();
    if (!file)
        throw std::runtime_error("cannot write " + path);
}

void write_table(const std::vector<Row>& rows, const std::string& path) {
    std::ofstream file(path);
    file << "time_s,heave_m,roll_deg,pitch_deg,water_m\n";
    char line[128];
    for (const Row& row : rows) {
        std::snprintf(line, sizeof line, "%.1f,%.4f,%.4f,%.4f,%.4f\n", row.time_s, row.heave_m,
                      row.roll_deg, row.pitch_deg, row.water_m);
        file << line;
    }
    finish(file, path);
}

constexpr double width = 900;
constexpr double panel = 150;
constexpr double left = 60;

/// One curve with its axis, `top` pixels down.
void plot(std::ofstream& file, const std::vector<Row>& rows, double Row::*value, const char* name,
          double top) {
    double reach = 1;
    for (const Row& row : rows)
        reach = std::max(reach, std::ceil(std::abs(row.*value)));
    const double middle = top + panel / 2;
    const double scale = (panel / 2 - 12) / reach;
    file << "<path d='M" << left << ' ' << middle << " H" << width << "' stroke='#bbb'/>\n";
    for (const double tick : {reach, 0.0, -reach})
        file << "<text x='" << left - 6 << "' y='" << middle - scale * tick + 4
             << "' text-anchor='end'>" << tick << "</text>\n";
    file << "<text x='" << left + 4 << "' y='" << top + 14 << "'>" << name
         << "</text>\n<polyline points='";
    for (const Row& row : rows)
        file << left + (width - left) * row.time_s / rows.back().time_s << ','
             << middle - scale * row.*value << ' ';
    file << "' fill='none' stroke='#1f5fa8'/>\n";
}

void write_plot(const std::vector<Row>& rows, const std::string& path) {
    std::ofstream file(path);
    file << "<svg xmlns='http://www.w3.org/2000/svg' width='" << width + 20 << "' height='"
         << 3 * panel + 40
         << "' font-family='sans-serif' font-size='12'>\n<rect width='100%' height='100%' "
            "fill='white'/>\n";
    plot(file, rows, &Row::heave_m, "heave, m", 0);
    plot(file, rows, &Row::roll_deg, "roll, degrees", panel);
    plot(file, rows, &Row::pitch_deg, "pitch, degrees", 2 * panel);
    for (int i = 0; i <= 6; ++i)
        file << "<text x='" << left + (width - left) * i / 6 << "' y='" << 3 * panel + 16
             << "' text-anchor='middle'>" << std::lround(rows.back().time_s * i / 6) << "</text>\n";
    file << "<text x='" << (width + left) / 2 << "' y='" << 3 * panel + 34
         << "' text-anchor='middle'>seconds</text>\n</svg>\n";
    finish(file, path);
}

} // namespace

int main(int argc, char** argv) {
    const double seconds = argc > 4 ? std::atof(argv[4]) : 600;
    if (argc < 2 || !(seconds >= 1))
        return std::fprintf(stderr, "usage: ship ws://HOST:PORT [ship.csv [ship.svg [SECONDS]]]\n"),
               2;
    try {
        seaway::Sea sea(argv[1]);
        const std::vector<Row> rows = sail(sea, seconds);
        write_table(rows, argc > 2 ? argv[2] : "ship.csv");
        write_plot(rows, argc > 3 ? argv[3] : "ship.svg");
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "ship: %s\n", error.what()), 1;
    }
    return 0;
}
