// SPDX-License-Identifier: Apache-2.0
// A thousand floats in the sea of a running server: one batch of points a step, and what a step takes.
//
//     c++ -O2 fleet.cpp $(pkg-config --cflags --libs seaway) -o fleet
//     ./fleet ws://127.0.0.1:9430 [STEPS]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include <seaway/buoyancy.h>
#include <seaway/seaway.hpp>
#include <seaway/seaway_engine.h>

namespace {

constexpr std::size_t floats = 1000;
constexpr std::size_t in_row = 40;
constexpr double apart_m = 25;
constexpr double step_s = 1.0 / 20;

/// A raft of 2 x 2 m that floats half out: four columns.
constexpr double places_m[12] = {0.5, 0.5, 0, -0.5, 0.5, 0, -0.5, -0.5, 0, 0.5, -0.5, 0};
constexpr double volumes_m3[4] = {0.4, 0.4, 0.4, 0.4};
constexpr std::size_t corners = 4;

seaway_hull raft() {
    seaway_hull hull{};
    hull.mass_kg = 820;
    hull.inertia_kgm2[0] = hull.inertia_kgm2[1] = 300;
    hull.inertia_kgm2[2] = 550;
    hull.added_mass[2] = 0.8;
    hull.linear_drag = 400;
    hull.quadratic_drag = 1;
    hull.vertices_m = places_m;
    hull.vertex_count = corners;
    hull.volumes_m3 = volumes_m3;
    hull.column_m = 0.4;
    return hull;
}

std::vector<seaway_body> fleet() {
    std::vector<seaway_body> bodies;
    for (std::size_t row = 0; row < floats / in_row; ++row)
        for (std::size_t i = 0; i < in_row; ++i)
            bodies.push_back(
                {{apart_m * static_cast<double>(i), apart_m * static_cast<double>(row), 0},
                 {1, 0, 0, 0},
                 {0, 0, 0},
                 {0, 0, 0}});
    return bodies;
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
}

struct Times {
    std::vector<double> water_us;
    std::vector<double> motion_us;
    double off_m = 0; ///< at the last step, how far the raft that is farthest from its water is
};

/// Of a raft's middle from the mean of the water at its corners.
double farthest_m(const std::vector<seaway_body>& bodies,
                  const std::vector<seaway_answer>& answers) {
    double off_m = 0;
    for (std::size_t i = 0; i < floats; ++i) {
        double water_m = 0;
        for (std::size_t corner = 0; corner < corners; ++corner)
            water_m += answers[i * corners + corner].height_m / corners;
        off_m = std::max(off_m, std::abs(bodies[i].position_m[2] - water_m));
    }
    return off_m;
}

double since_us(std::chrono::steady_clock::time_point then) {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - then)
        .count();
}

/// One step of all. Whether there was water to step in: none before the first of it has come, and for a moment where it becomes another sea.
bool step(const seaway::Sea& sea, const seaway_sampling& how, const seaway_hull& hull,
          std::int64_t time_us, std::vector<seaway_body>& bodies, std::vector<seaway_point>& points,
          std::vector<seaway_answer>& answers, Times& times) {
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < floats; ++i)
        seaway_hull_points(&hull, &bodies[i], time_us, &points[i * corners]);
    const seaway_code code =
        seaway_sample_as(sea.handle(), &how, points.data(), points.size(), answers.data());
    if (code == SEAWAY_NOT_HELD)
        return false;
    if (code != SEAWAY_OK)
        throw seaway::SeaError(code);
    times.water_us.push_back(since_us(begin));
    times.off_m = farthest_m(bodies, answers);
    const auto sampled = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < floats; ++i)
        if (seaway_hull_step(&hull, &bodies[i], &points[i * corners], &answers[i * corners],
                             step_s) != SEAWAY_OK)
            throw std::runtime_error("a float takes no such step");
    times.motion_us.push_back(since_us(sampled));
    return true;
}

int run(const char* url, int steps) {
    seaway::Sea sea(url);
    sea.subscribe();
    const seaway_hull hull = raft();
    std::vector<seaway_body> bodies = fleet();
    std::vector<seaway_point> points(floats * corners);
    std::vector<seaway_answer> answers(points.size());
    // Floats drift by centimetres a step: where a point's water came from is where to look for it.
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    if (seaway_open_probe(points.size(), &how.probe) != SEAWAY_OK)
        return std::fprintf(stderr, "fleet: %s\n", seaway_last_error()), 1;
    const std::unique_ptr<seaway_probe, decltype(&seaway_close_probe)> probe(how.probe,
                                                                             &seaway_close_probe);
    Times times;
    int without = 0;
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < steps; ++i) {
        std::this_thread::sleep_until(begin + i * std::chrono::duration<double>(step_s));
        if (!step(sea, how, hull, sea.now_us(), bodies, points, answers, times))
            ++without;
    }
    if (times.water_us.empty())
        return std::fprintf(stderr, "fleet: no water came\n"), 1;
    if (without > 0)
        std::printf("%d steps were left out, without water; ", without);
    std::printf(
        "%zu floats, %zu points in one batch: a step takes %.0f us for the water and %.0f us for "
        "the floats (medians of %zu); none is further than %.2f m from the water\n",
        floats, points.size(), median(times.water_us), median(times.motion_us),
        times.water_us.size(), times.off_m);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    const int steps = argc > 2 ? std::atoi(argv[2]) : 200;
    if (argc < 2 || steps < 1)
        return std::fprintf(stderr, "usage: fleet ws://HOST:PORT [STEPS]\n"), 2;
    try {
        return run(argv[1], steps);
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "fleet: %s\n", error.what()), 1;
    }
}
