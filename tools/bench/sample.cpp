// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/sample.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/quantile.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "server/device/device_choice.h"
#include "server/simulation/running_sea.h"

namespace seaway::bench {

namespace {

using sea::AnswerParts;
using sea::TimeUs;

/// CPU time of this thread, ns: what others do on the machine costs it caches at most.
double thread_ns() {
    return 1e9 * thread_cpu_seconds();
}

/// The clock takes as long as a point: so many points lie between two looks at it.
constexpr std::size_t timed_points_min = 16;
constexpr double reach_m = 10e3;
/// Places are drawn before anything is timed; batches take the next of them.
constexpr std::size_t places_drawn = 1 << 16;

/// All cascades around one time.
struct HeldSurface {
    sea::Surface surface;
    TimeUs start_us;
    TimeUs end_us; ///< of the shortest interval
};

Result<HeldSurface> held_surface(const server::RunningSea& sea) {
    SEAWAY_TRY_LET(const auto device, server::make_synthesizer("native"));
    SEAWAY_TRY(device->set_sea(sea.realization, sea.epoch));
    std::vector<sea::SplinePair> pairs;
    TimeUs end_us = sea::time_us_max;
    for (std::size_t c = 0; c < sea.budget.cascades.size(); ++c) {
        const TimeUs interval_us = sea.budget.cascades[c].interval_us;
        std::vector<server::KeyframeRequest> requests;
        for (const TimeUs time_us : {TimeUs{0}, interval_us})
            requests.push_back({static_cast<int>(c), time_us, sea::surface_fields});
        SEAWAY_TRY_LET(const auto made, device->synthesize(requests));
        pairs.push_back({std::make_shared<const sea::SplineMap>(*made[0]),
                         std::make_shared<const sea::SplineMap>(*made[1])});
        end_us = std::min(end_us, interval_us);
    }
    return HeldSurface{sea::Surface(std::move(pairs), sea.realization->choppiness,
                                    sea::fold_search(sea.budget), sea::map_error(sea.budget, 0.0),
                                    sea::inverse_tolerance_m(sea.budget.height_error_m)),
                       0, end_us};
}

enum class Times { shared, same, own, drifting, probe, unremembered };

/// A point of a hull, asked about step after step; of the last with what it knows from the one before. The same places and times.
bool is_hull(Times times) {
    return times == Times::probe || times == Times::unremembered;
}

struct Way {
    std::size_t points;
    Times times;
    AnswerParts parts;
};

std::string_view name(Times times) {
    switch (times) {
    case Times::shared:
        return "one, new each batch";
    case Times::same:
        return "one, always the same";
    case Times::own:
        return "each its own";
    case Times::drifting:
        return "always the same, drifting";
    case Times::unremembered:
        return "new each step, a hull's";
    case Times::probe:
        return "the same with a probe";
    }
    return "";
}

/// It makes way, and lies in the span of the keyframes that are held: a step is a 60th of a second, and the last one of the span leads
/// back to its beginning, a jump in some tens of steps.
sea::QueryPoint on_a_hull(const HeldSurface& held, std::size_t step) {
    constexpr double way_mps = 5, step_s = 1.0 / 60;
    const auto steps = static_cast<double>(step);
    const TimeUs passed_us = std::llround(1e6 * steps * step_s) % (held.end_us - held.start_us);
    return {300.0 + way_mps * step_s * steps, 200.0, held.start_us + passed_us};
}

std::vector<sea::QueryPoint> drawn(const HeldSurface& held, const Way& way) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> place(-reach_m, reach_m);
    std::uniform_int_distribution<TimeUs> time(held.start_us, held.end_us - 1);
    const TimeUs same_us = time(random);
    TimeUs time_us = same_us;
    std::vector<sea::QueryPoint> points;
    for (std::size_t i = 0; i < places_drawn; ++i) {
        if (way.times == Times::own || (way.times == Times::shared && i % way.points == 0))
            time_us = time(random);
        const double x_m = place(random), y_m = place(random);
        points.push_back({x_m, y_m, time_us});
        if (way.times == Times::drifting) // by centimetres, and no time passes
            points.back() = {300.0 + 1e-6 * x_m, 200.0 + 1e-6 * y_m, same_us};
        if (is_hull(way.times))
            points.back() = on_a_hull(held, i);
    }
    return points;
}

void measure(const HeldSurface& held, const Way& way, const SampleOptions& options) {
    const std::vector<sea::QueryPoint> points = drawn(held, way);
    std::vector<sea::Answer> answers(way.points);
    const sea::PointKernel& kernel = sea::point_kernel(
        options.kernel == "portable" ? Instructions::portable : best_instructions());
    sea::MixedMaps mixed; // as a client has
    std::vector<sea::PointMemory> memory(way.times == Times::probe ? way.points : 0);
    std::vector<double> each_ns;
    std::size_t first = 0;
    const double end = thread_ns() + 1e9 * options.seconds;
    for (double before = thread_ns(); before < end;) {
        std::size_t count = 0;
        for (; count < std::max(timed_points_min, way.points); count += way.points) {
            held.surface.answer({&points[first], way.points}, answers,
                                {.parts = way.parts, .mixed = &mixed, .memory = memory}, kernel);
            first = (first + way.points) % places_drawn;
        }
        const double after = thread_ns();
        each_ns.push_back((after - before) / static_cast<double>(count));
        before = thread_ns();
    }
    const double median_ns = quantile(each_ns, 0.5), late_ns = quantile(each_ns, 0.99);
    fmt::print("{:>6}  {:<25} {:<8} {:>9.0f} {:>9.0f} {:>10.2f}\n", way.points, name(way.times),
               way.parts == AnswerParts::all ? "all" : "height", median_ns, late_ns,
               1e3 / median_ns);
}

} // namespace

Result<void> run_sample(const SampleOptions& options) {
    SEAWAY_TRY_LET(const sea::Scene scene, sea::read_scene(options.scene));
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, server::make_running_sea(scene, 1));
    SEAWAY_TRY_LET(const HeldSurface held, held_surface(*sea));
    fmt::print("{:>6}  {:<25} {:<8} {:>9} {:>9} {:>10}\n", "points", "times", "parts", "ns, p50",
               "ns, p99", "M a second");
    const auto wanted = [&](std::size_t points) {
        return options.points == 0 || static_cast<std::size_t>(options.points) == points;
    };
    for (const AnswerParts parts : {AnswerParts::height, AnswerParts::all}) {
        if (wanted(1))
            for (const Times times : {Times::drifting, Times::unremembered, Times::probe})
                measure(held, {1, times, parts}, options);
        for (const Times times : {Times::shared, Times::same, Times::own})
            for (const std::size_t points : {std::size_t{1}, std::size_t{64}, std::size_t{1024}})
                if (wanted(points))
                    measure(held, {points, times, parts}, options);
    }
    return {};
}

} // namespace seaway::bench
