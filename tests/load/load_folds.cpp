// SPDX-License-Identifier: Apache-2.0
// Do answers in seas that fold find every sheet? Steep seas, their maps by the native device as the
// server makes them; points that were chosen near folds; answers from maps and from the exact sum, held
// against brute force in double precision (brute_sheets.h). In this process, without a server.
//
//     load_folds                          some thousand points of each sea: a minute
//     load_folds --samples 1000000        rounds with new times, places and seas
//     load_folds --scene FILE             of this sea alone
//
// What contradicts an answer is followed by the exact sum before it counts, and does not count where the signs of J tell that
// brute force has overlooked a sheet. Prints a row a sea and way:
// points; those with several sheets; of these, how many without a flag; answers not flagged open that are of
// another sheet than the highest, or further off than half as much again as their bound (misses): there may be
// none; those beyond their bound by less (beyond): 1 in 100 000 at most, of a bound that is stated for 99.9 %.
// Of the points with several sheets: the share where the answer is the highest within 5 cm; where it is
// within its bound or 5 cm, or the maps have that sheet no further away than they are wrong sideways; the
// share of decidable ones, whose highest sheet ends further away than that, and of these the share where
// the answer is the highest within its bound or 5 cm; the share not flagged open, and of these likewise.
// Of all points the share flagged though there is one sheet, and CPU time.
// Exit code 1: a miss, or more beyond their bound than that.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/elapsed.h"
#include "sea/surface/surface.h"
#include "server/device/native_synthesizer.h"
#include "server/simulation/running_sea.h"
#include "server/simulation/schedule.h"
#include "tests/load/brute_sheets.h"
#include "tests/load/random_scenes.h"
#include "tests/support/draw.h"

using namespace seaway;
using sea::Answer;
using sea::Vec2;
using tests::BruteSheet;
using Clock = std::chrono::steady_clock;

namespace {

struct Options {
    std::uint64_t seed = 1;
    std::uint64_t samples = 0;
    double seconds = 0;
    int points = 2000;        ///< a place and time
    double exact_share = 0.1; ///< of them asked of the exact sum too
    std::vector<std::string> scenes{};
    std::vector<std::string> only{};
};

struct Way {
    std::uint64_t points = 0, several = 0, unflagged = 0, misses = 0, beyond = 0, within_5_cm = 0,
                  beside = 0, decidable = 0, decidable_right = 0, settled = 0, settled_right = 0,
                  flagged = 0;
    double seconds = 0;
};

struct Tally {
    double squeeze = 0;
    std::uint64_t points = 0, several = 0, overlooked = 0;
    Way maps{}, exact{};
};

struct Sea {
    std::string name;
    std::string toml;
};

double now_s() {
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

std::vector<Sea> steep_seas(std::uint64_t seed) {
    std::vector<Sea> seas;
    seas.push_back(
        {"swell of 120 m",
         fmt::format("[sea]\nseed = {}\nheight_scale = 3\n[[sea.system]]\ntype = \"swell\"\n"
                     "spectrum = \"jonswap\"\nfrom_deg = 250\nsignificant_height_m = 40\n"
                     "peak_period_s = 25\nspreading = \"cos2s\"\nspreading_exponent = 10\n"
                     "[[cascade]]\nlength_m = 9001\nsize = 256\n[[cascade]]\nlength_m = "
                     "1201\nsize = 256\n",
                     19 + seed)});
    tests::Draw draw(seed);
    std::string systems = fmt::format("[sea]\nseed = {}\nchoppiness = 1.5\n", seed);
    for (int i = 0; i < 16; ++i)
        systems += fmt::format(
            "[[sea.system]]\ntype = \"swell\"\nspectrum = \"jonswap\"\nfrom_deg = {:.1f}\n"
            "significant_height_m = {:.3g}\npeak_period_s = {:.3g}\nspreading = \"cos2s\"\n"
            "spreading_exponent = {:.3g}\n",
            draw.uniform(0, 359), draw.uniform(1, 3), draw.uniform(4, 12), draw.uniform(2, 40));
    seas.push_back({"16 systems", systems});
    for (const double choppiness : {1.5, 2.0, 3.0})
        seas.push_back(
            {fmt::format("hurricane at {}", choppiness),
             fmt::format(
                 "[sea]\nseed = {}\nchoppiness = {}\n[[sea.system]]\ntype = \"wind\"\n"
                 "spectrum = \"jonswap\"\nfrom_deg = 140\nwind_speed_10m_mps = 50\nfetch_m = "
                 "300e3\nspreading = \"donelan_banner\"\n",
                 seed, choppiness)});
    for (const double choppiness : {1.5, 2.0, 2.5})
        seas.push_back(
            {fmt::format("young wind sea at {}", choppiness),
             fmt::format(
                 "[sea]\nseed = {}\nchoppiness = {}\n[[sea.system]]\ntype = \"wind\"\n"
                 "spectrum = \"jonswap\"\nfrom_deg = 20\nwind_speed_10m_mps = 15\nfetch_m = "
                 "5e3\nspreading = \"cos2\"\n",
                 seed, choppiness)});
    for (int i = 0; i < 40; ++i) {
        const tests::RandomScene drawn = tests::random_scene(seed, i);
        if (drawn.oddity == tests::Oddity::steep || drawn.oddity == tests::Oddity::many_tiles)
            seas.push_back(
                {fmt::format("{} {}", name(drawn.oddity), i / tests::oddity_count), drawn.toml});
    }
    return seas;
}

class Folds {
  public:
    explicit Folds(Options options) : options_(std::move(options)) {}

    int run() {
        const double start_s = now_s();
        const auto over = [&] {
            return points_ >= options_.samples && now_s() - start_s >= options_.seconds;
        };
        for (std::uint64_t round = 0; round == 0 || !over(); ++round) {
            const std::uint64_t seed = options_.seed + round;
            tests::Draw draw(seed);
            for (const Sea& sea : seas(seed)) {
                if (!options_.only.empty() && std::find(options_.only.begin(), options_.only.end(),
                                                        sea.name) == options_.only.end())
                    continue;
                look_at(sea, draw);
                if (round > 0 && over())
                    break;
            }
        }
        print();
        return misses_ > 0 || beyond_ * 100'000 > points_ ? 1 : 0;
    }

  private:
    std::vector<Sea> seas(std::uint64_t seed) const {
        std::vector<Sea> all;
        for (const std::string& path : options_.scenes)
            all.push_back({path, ""});
        return all.empty() ? steep_seas(seed) : all;
    }

    void look_at(const Sea& named, tests::Draw& draw) {
        const auto scene = named.toml.empty() ? sea::read_scene(named.name)
                                              : sea::parse_scene(named.toml, named.name, ".");
        const auto running = scene ? server::make_running_sea(*scene, 1)
                                   : Result<server::RunningSeaPtr>(scene.error());
        if (!running) {
            fmt::print("{}: {}\n", named.name, running.error().message);
            std::exit(2);
        }
        const server::RunningSea& sea = **running;
        const sea::TimeUs time_us =
            sea::us_from_seconds(draw.one_of({0.0, draw.uniform(0, 1e4), draw.uniform(-1e7, 1e8)}));
        const tests::BruteField field(*sea.realization, time_us);
        const sea::Surface surface = surface_of(*running, time_us);
        const sea::DirectSum::Moment moment = sea.truth->at_time(time_us);

        // Where the surface folds most strongly of some thousand places.
        Vec2 steepest{};
        double least = 1e9;
        for (int i = 0; i < 20'000; ++i) {
            const Vec2 X{draw.uniform(-2e4, 2e4), draw.uniform(-2e4, 2e4)};
            const auto p = field.at(X);
            if (const double j = jacobian(p, field.choppiness()); j < least) {
                least = j;
                steepest = field.landed(X, p);
            }
        }
        const double half_m = std::max(100 * field.finest_m(), 0.25 * field.reach_m());
        const tests::BruteSheets brute(field, steepest, half_m);
        Tally& tally = tallies_[named.name];
        tally.squeeze = sea.realization->choppiness.largest() * sea.budget.rms_strain;
        for (int i = 0; i < options_.points; ++i) {
            const Vec2 x = near_a_fold(brute, steepest, half_m, draw);
            judge(named.name, tally, sea, surface, moment, field, brute, {x.x, x.y, time_us},
                  draw.uniform(0, 1) < options_.exact_share);
        }
    }

    /// Two of three below places with J < 0.3, the others anywhere.
    static Vec2 near_a_fold(const tests::BruteSheets& brute, Vec2 centre, double half_m,
                            tests::Draw& draw) {
        const double level = draw.one_of({0.02, 0.3, 1e9});
        const double jitter_m = brute.step_m();
        for (int i = 0; i < 2000 && !brute.places().empty(); ++i) {
            const auto& place = brute.places()[draw.below(brute.places().size())];
            const Vec2 x{place.landed.x + draw.uniform(-jitter_m, jitter_m),
                         place.landed.y + draw.uniform(-jitter_m, jitter_m)};
            if (place.jacobian < level && std::abs(x.x - centre.x) < half_m &&
                std::abs(x.y - centre.y) < half_m)
                return x;
        }
        return {centre.x + draw.uniform(-half_m, half_m), centre.y + draw.uniform(-half_m, half_m)};
    }

    sea::Surface surface_of(const server::RunningSeaPtr& running, sea::TimeUs time_us) {
        const server::RunningSea& sea = *running;
        const auto wanted = server::keyframes_around(*server::steady_course(running), {&time_us, 1},
                                                     {~0u, sea.sampler_fields()});
        SEAWAY_CHECK(native_.set_sea(sea.realization, 1).has_value(), "set_sea");
        const auto made = native_.synthesize(wanted);
        SEAWAY_CHECK(made.has_value(), "synthesize");
        std::vector<sea::SplinePair> pairs;
        for (std::size_t i = 0; i < made->size(); i += 2)
            pairs.push_back({std::make_shared<const sea::SplineMap>(*(*made)[i]),
                             std::make_shared<const sea::SplineMap>(*(*made)[i + 1])});
        return {std::move(pairs), sea.realization->choppiness, fold_search(sea.budget),
                map_error(sea.budget, 0.0)};
    }

    void judge(const std::string& name, Tally& tally, const server::RunningSea& sea,
               const sea::Surface& surface, const sea::DirectSum::Moment& moment,
               const tests::BruteField& field, const tests::BruteSheets& brute,
               const sea::QueryPoint& point, bool ask_exact) {
        ++tally.points;
        ++points_;
        const std::vector<BruteSheet> sheets = brute.above({point.x_m, point.y_m});
        tally.several += sheets.size() > 1;
        double start_s = thread_cpu_seconds();
        const Answer mapped = surface.answer(point);
        tally.maps.seconds += thread_cpu_seconds() - start_s;
        judge_way(name + ", maps", tally, tally.maps, moment, field, sheets, point, mapped,
                  &surface);
        if (!ask_exact)
            return;
        const double tolerance_m = sea::exact_tolerance_m(point);
        start_s = thread_cpu_seconds();
        Answer exact = surface_at(
            point, {sea.realization->choppiness, tolerance_m, fold_search(sea.budget)}, moment);
        tally.exact.seconds += thread_cpu_seconds() - start_s;
        exact.error_m += tolerance_m;
        judge_way(name + ", exact", tally, tally.exact, moment, field, sheets, point, exact,
                  nullptr);
    }

    void judge_way(const std::string& name, Tally& tally, Way& way,
                   const sea::DirectSum::Moment& moment, const tests::BruteField& field,
                   const std::vector<BruteSheet>& brute, const sea::QueryPoint& point,
                   const Answer& answer, const sea::Surface* maps) {
        ++way.points;
        const bool flagged = (answer.flags & sea::answer_folded) != 0;
        const bool open = (answer.flags & sea::answer_open) != 0;
        const auto top_of = [](const std::vector<BruteSheet>& sheets) {
            double top_m = -1e9;
            for (const BruteSheet& s : sheets)
                top_m = std::max(top_m, s.height_m);
            return top_m;
        };
        std::vector<BruteSheet> sheets = brute;
        // Brute force itself is done at 1e-9 m.
        const double bound_m = answer.error_m + 1e-7;
        const auto settled = [&] {
            const double off_m = std::abs(answer.height_m - top_of(sheets));
            if (flagged && open)
                return sheets.size() == 1 || off_m <= 1e-4;
            return (flagged || sheets.size() == 1) && off_m <= bound_m;
        };
        if (!settled())
            sheets = polish(moment, {point.x_m, point.y_m}, brute);
        if (sheets.empty() || (!settled() && !complete(sheets))) {
            ++tally.overlooked;
            return;
        }
        const double off_m = std::abs(answer.height_m - top_of(sheets));
        way.flagged += flagged && sheets.size() == 1;
        if (sheets.size() > 1) {
            ++way.several;
            const bool right = off_m <= std::max(0.05, bound_m);
            const BruteSheet& top = *std::max_element(
                sheets.begin(), sheets.end(),
                [](const BruteSheet& a, const BruteSheet& b) { return a.height_m < b.height_m; });
            const bool decidable =
                maps == nullptr || ends_within_m(field, top) > maps->fold_blur_m();
            way.within_5_cm += off_m <= 0.05;
            way.beside += right || (maps && found_beside(*maps, point, top.height_m));
            way.decidable += decidable;
            way.decidable_right += decidable && right;
            way.settled += !open;
            way.settled_right += !open && right;
        }
        if (open || settled())
            return;
        way.unflagged += !flagged && sheets.size() > 1;
        if (off_m > 1.5 * bound_m || (off_m > bound_m && sheets.size() > 1)) {
            ++way.misses;
            ++misses_;
        } else if (off_m > bound_m) {
            ++way.beyond;
            ++beyond_;
        }
        report(name, point, answer, sheets);
    }

    /// Counted with the signs of their J, all sheets above a place are one: else brute force has overlooked some.
    static bool complete(const std::vector<BruteSheet>& sheets) {
        int signs = 0;
        for (const BruteSheet& s : sheets)
            signs += s.jacobian > 0 ? 1 : -1;
        return signs == 1;
    }

    static void report(const std::string& name, const sea::QueryPoint& point, const Answer& answer,
                       const std::vector<BruteSheet>& sheets) {
        fmt::print("{}: at {},{} t = {} us: {:.6f} +- {:.3g}, flags {}; sheets", name, point.x_m,
                   point.y_m, point.time_us, answer.height_m, answer.error_m, answer.flags);
        for (const BruteSheet& s : sheets)
            fmt::print(" {:.6f} (J {:.4f} at {:.3f},{:.3f})", s.height_m, s.jacobian, s.at.x,
                       s.at.y);
        fmt::print("\n");
        std::fflush(stdout);
    }

    /// The maps have the sheet no further away than they are wrong sideways: it ends at a fold here.
    static bool found_beside(const sea::Surface& maps, const sea::QueryPoint& point, double top_m) {
        for (const double share : {0.1, 0.3, 0.6, 1.0})
            for (int i = 0; i < 8; ++i) {
                const double angle = sea::two_pi * i / 8;
                const Answer there = maps.answer(
                    {point.x_m + share * maps.fold_blur_m() * std::cos(angle),
                     point.y_m + share * maps.fold_blur_m() * std::sin(angle), point.time_us});
                if (std::abs(there.height_m - top_m) <= std::max(0.05, there.error_m))
                    return true;
            }
        return false;
    }

    void print() const {
        fmt::print("sea,squeeze,way,points,several,unflagged,misses,beyond,within_5cm,or_beside,"
                   "decidable,right,settled,right,flagged_with_one,us_a_point\n");
        for (const auto& [name, tally] : tallies_)
            for (const auto& [way_name, way] :
                 {std::pair("maps", &tally.maps), std::pair("exact", &tally.exact)}) {
                const auto share = [](std::uint64_t part, std::uint64_t whole) {
                    return static_cast<double>(part) /
                           static_cast<double>(std::max<std::uint64_t>(whole, 1));
                };
                fmt::print(
                    "{},{:.3f},{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},"
                    "{:.1f}\n",
                    name, tally.squeeze, way_name, way->points, way->several, way->unflagged,
                    way->misses, way->beyond, share(way->within_5_cm, way->several),
                    share(way->beside, way->several), share(way->decidable, way->several),
                    share(way->decidable_right, way->decidable), share(way->settled, way->several),
                    share(way->settled_right, way->settled), share(way->flagged, way->points),
                    1e6 * way->seconds /
                        static_cast<double>(std::max<std::uint64_t>(way->points, 1)));
            }
        std::uint64_t overlooked = 0;
        for (const auto& [name, tally] : tallies_)
            overlooked += tally.overlooked;
        fmt::print(
            "{} points, {} misses, {} beyond their bound, {} where brute force overlooked sheets\n",
            points_, misses_, beyond_, overlooked);
    }

    const Options options_;
    server::NativeSynthesizer native_{1};
    std::map<std::string, Tally> tallies_;
    std::uint64_t points_ = 0, misses_ = 0, beyond_ = 0;
};

} // namespace

int main(int argc, char** argv) {
    CommandLine line("load_folds", "Seas that fold: are all sheets found?");
    Options options;
    line.option("--seed", options.seed);
    line.option("--points", options.points, "a sea and time").between(1, 1'000'000);
    line.option("--seconds", options.seconds).between(0.0, 1e9);
    line.option("--samples", options.samples);
    line.option("--exact", options.exact_share, "share of points asked of the exact sum")
        .between(0.0, 1.0);
    line.option("--scene", options.scenes);
    line.option("--only", options.only, "of these seas");
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "load_folds: {}\n", next.error().message);
        return 2;
    }
    return *next == CommandLine::Next::leave ? 0 : Folds(options).run();
}
