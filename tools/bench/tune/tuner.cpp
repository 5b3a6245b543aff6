// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/tune/tuner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include <fmt/format.h>

#include "tools/bench/accuracy/measure/laws.h"
#include "tools/bench/tune/total_error.h"

namespace seaway::bench {

namespace {

/// Laws and measurements differ by less: what they expect to be worse is not tried.
constexpr double law_slack = 1.1;
/// Answers that cost so many times the least possible look for folds.
constexpr double searched_above = 1.6;
/// The most accurate layout of all is measured at few places: it has the most waves, and folds everywhere. What
/// it leaves out, which the spectrum gives, is most of its error.
constexpr Sampling best_sampling{64, 2, false};
/// Likewise of slopes, whose law leaves out what displacements do.
constexpr double slope_law_slack = 1.2;
/// What differs by less is the same to who asks for the best there is.
constexpr double as_good = 1.1;
/// So many layouts between two lines of progress.
constexpr int layouts_a_line = 50;

std::string in_words(const Candidate& c) {
    std::string tiles;
    for (const sea::CascadeSpec& cascade : c.layout.cascades)
        tiles +=
            fmt::format("{}{:g} m/{}", tiles.empty() ? "" : ", ", cascade.length_m, cascade.size);
    return fmt::format("{} with height_error_m = {:g}, {:.1f} ms/s", tiles, c.height_error_m,
                       c.price.work_ms());
}

class Search {
  public:
    Search(const sea::Scene& scene, const Target& target, const TuneSpace& space,
           const TuneOptions& options, Prices& prices, Devices& devices)
        : scene_(scene), target_(target), space_(space), options_(options), prices_(prices),
          devices_(devices), sigmas_(normal_percentile(target.percentile)) {}

    Result<Outcome> run();

  private:
    /// A layout with a lower bound of its price; with how many budgets may do, and a better bound; or a
    /// candidate with its price.
    struct Entry {
        double price_ms;
        std::size_t layout; ///< settles ties, so that the order is one
        std::optional<std::size_t> budgets = {};
        std::optional<std::size_t> budget = {}; ///< of the candidate, in height_errors_m
        Candidate candidate = {};
        bool operator<(const Entry& other) const { // the cheapest on top
            return price_ms != other.price_ms ? price_ms > other.price_ms : layout > other.layout;
        }
    };
    struct Laid {
        Layout layout;
        double missing_m;
    };

    void say(const std::string& line) const {
        if (options_.progress)
            options_.progress(line);
    }
    double missing(const Layout& layout) const;
    /// A layout's waves, with a budget; null where the scene's own waves do not fit it.
    const Waves* waves_of(std::size_t layout, double height_error_m);
    Configuration configuration(std::size_t layout, double height_error_m) const;
    /// What the laws expect: heights at the percentile, slopes rms.
    struct Expected {
        double error_m;
        double slope_rms;
    };
    Expected expected(std::size_t layout, const Waves& waves) const;
    /// What the laws may say of a configuration that is worth measuring.
    Expected allowed() const {
        return {target_.height_error_m * law_slack / margin,
                target_.slope_error ? *target_.slope_error * slope_law_slack / margin
                                    : std::numeric_limits<double>::infinity()};
    }
    /// How many of the budgets the laws expect to be this accurate, the smallest first.
    std::size_t budgets_within(std::size_t layout, const Expected& most);
    Result<std::optional<Candidate>> priced(std::size_t layout, std::size_t budget);
    /// With the cheapest of the first `budgets`.
    Result<void> offer(std::size_t layout, std::size_t budgets);
    Result<void> look_at(std::size_t layout);
    /// A bound by the intervals of the largest budget.
    Result<void> bound(std::size_t layout, std::size_t budgets);
    Result<void> try_candidate(const Entry& entry, Outcome& outcome);
    Result<std::string> why_not(const Candidate& candidate,
                                std::vector<sea::MeasuredError>& measured);
    Result<std::string> why_not(const sea::Scene& scene, const char* name, std::uint64_t seed,
                                std::vector<sea::MeasuredError>& measured);
    bool too_dear(const Price& price) const {
        return (target_.budget_ms && price.work_ms() > *target_.budget_ms) ||
               (target_.bytes_per_s && price.bytes_per_s > *target_.bytes_per_s);
    }
    Result<void> most_accurate(Outcome& outcome);
    /// Where slopes alone are in the way: the layout whose slopes are the best by the laws.
    Result<bool> best_slopes(Outcome& outcome);
    Result<void> measure_best(Outcome& outcome, const Sampling& sampling);

    const sea::Scene& scene_;
    const Target target_;
    const TuneSpace& space_;
    const TuneOptions& options_;
    Prices& prices_;
    Devices& devices_;
    const double sigmas_;
    std::vector<Laid> laid_;
    std::vector<Price> at_least_;
    std::vector<double>
        least_slope_; ///< expected with the smallest budget, of layouts that were looked at
    std::size_t drawn_ = std::numeric_limits<std::size_t>::max(); ///< whose waves_ are
    std::optional<Waves> waves_;
    std::priority_queue<Entry> queue_;
    int looked_at_ = 0, priced_ = 0, tried_ = 0;
};

double Search::missing(const Layout& layout) const {
    // Bands are all that the law looks at.
    auto bands = std::make_shared<sea::Realization>();
    const Result<std::vector<sea::Band>> all = sea::assign_bands(layout.cascades);
    for (const sea::Band& band : all.value())
        bands->cascades.emplace_back().band = band;
    Waves waves;
    waves.state = scene_.sea;
    waves.used = bands;
    return missing_waves(waves).rms_m();
}

Configuration Search::configuration(std::size_t layout, double height_error_m) const {
    Configuration c = configuration_of(scene_, options_.device);
    c.cascades = laid_[layout].layout.cascades;
    c.height_error_m = height_error_m;
    return c;
}

const Waves* Search::waves_of(std::size_t layout, double height_error_m) {
    const Configuration wanted = configuration(layout, height_error_m);
    if (drawn_ != layout) {
        drawn_ = layout;
        Result<Waves> waves = configured_waves(scene_, wanted);
        waves_ = waves ? std::optional(*std::move(waves)) : std::nullopt;
    }
    if (!waves_)
        return nullptr;
    waves_->budget = budget_of(*waves_->used, wanted);
    return &*waves_;
}

Search::Expected Search::expected(std::size_t layout, const Waves& waves) const {
    const Prediction law = predict(waves, configuration(layout, waves.budget.height_error_m), 0);
    return {sigmas_ * std::hypot(law.rms_m(), laid_[layout].missing_m), law.slope_rms};
}

Result<std::optional<Candidate>> Search::priced(std::size_t layout, std::size_t budget) {
    Candidate candidate{laid_[layout].layout, space_.height_errors_m[budget], {}, 0, 0};
    const Waves* waves = waves_of(layout, candidate.height_error_m);
    if (waves == nullptr)
        return std::optional<Candidate>();
    SEAWAY_TRY_LET(
        const auto sea,
        ConfiguredSea::create(*waves, configuration(layout, candidate.height_error_m), devices_));
    SEAWAY_TRY(sea->go_to(sample_time_us(1)));
    SEAWAY_TRY_LET(candidate.price, prices_.of(*sea));
    const Expected law = expected(layout, *waves);
    candidate.expected_m = law.error_m;
    candidate.expected_slope = law.slope_rms;
    ++priced_;
    return std::optional(candidate);
}

std::size_t Search::budgets_within(std::size_t layout, const Expected& most) {
    std::size_t low = 0, high = space_.height_errors_m.size(); // the first that does not do
    while (low < high) {
        const std::size_t middle = (low + high) / 2;
        const Waves* waves = waves_of(layout, space_.height_errors_m[middle]);
        if (waves == nullptr)
            return 0;
        const Expected law = expected(layout, *waves);
        if (middle == 0)
            least_slope_[layout] = law.slope_rms;
        if (law.error_m <= most.error_m && law.slope_rms <= most.slope_rms)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/// Of the first `budgets` the largest is the cheapest, unless it is so large that answers must look for
/// folds: then the largest with which they need not.
Result<void> Search::offer(std::size_t layout, std::size_t budgets) {
    std::optional<Candidate> best;
    std::size_t best_budget = 0, low = 0, high = budgets;
    for (std::size_t budget = budgets - 1; low < high; budget = (low + high) / 2) {
        SEAWAY_TRY_LET(const std::optional<Candidate> candidate, priced(layout, budget));
        if (!candidate)
            return {};
        if (!best || candidate->price.work_ms() < best->price.work_ms()) {
            best = candidate;
            best_budget = budget;
        }
        if (candidate->price.answers_ms > searched_above * at_least_[layout].answers_ms)
            high = budget;
        else
            low = budget + 1;
    }
    if (best && !too_dear(best->price))
        queue_.push({best->price.work_ms(), layout, budgets, best_budget, *best});
    return {};
}

Result<void> Search::bound(std::size_t layout, std::size_t budgets) {
    if (budgets == 0)
        return {};
    const Waves* waves = waves_of(layout, space_.height_errors_m[budgets - 1]);
    SEAWAY_TRY_LET(const Price price,
                   prices_.at_least(laid_[layout].layout.cascades, scene_, &waves->budget));
    queue_.push({price.work_ms(), layout, budgets});
    return {};
}

Result<std::string> Search::why_not(const sea::Scene& scene, const char* name, std::uint64_t seed,
                                    std::vector<sea::MeasuredError>& measured) {
    sea::Scene sea = scene;
    sea.sea.seed = seed;
    SEAWAY_TRY_LET(sea::MeasuredError error,
                   measure_error(sea, name, target_.percentile, options_, devices_));
    measured.push_back(error);
    if (!(error.total_m * margin <= target_.height_error_m)) // nor a NaN
        return fmt::format("{:.4g} m {}", error.total_m, name);
    if (target_.slope_error && !(error.slope_rms * margin <= *target_.slope_error))
        return fmt::format("slope {:.4g} {}", error.slope_rms, name);
    return std::string();
}

/// Empty: it keeps the target in every sea.
Result<std::string> Search::why_not(const Candidate& candidate,
                                    std::vector<sea::MeasuredError>& measured) {
    const sea::Scene scene = with_candidate(scene_, candidate);
    SEAWAY_TRY_LET(std::string why, why_not(scene, "as given", scene.sea.seed, measured));
    const auto also = [&](const sea::Scene& sea, const char* name, int number) -> Result<void> {
        if (why.empty()) {
            const std::uint64_t seed =
                fresh_seed(options_.seed, static_cast<std::uint64_t>(number));
            SEAWAY_TRY_LET(why, why_not(sea, name, seed, measured));
        }
        return {};
    };
    for (int i = 0; i < options_.fresh_seeds; ++i)
        SEAWAY_TRY(also(scene, "as given", i));
    if (const double share = options_.envelope_share; share > 0) {
        SEAWAY_TRY(also(grown(scene, 1.0 + share), "rougher", 1000));
        SEAWAY_TRY(also(grown(scene, 1.0 - share), "calmer", 1001));
    }
    return why;
}

Result<void> Search::try_candidate(const Entry& entry, Outcome& outcome) {
    ++tried_;
    say(fmt::format("measuring {} ({} priced)", in_words(entry.candidate), priced_));
    std::vector<sea::MeasuredError> measured;
    SEAWAY_TRY_LET(const std::string why, why_not(entry.candidate, measured));
    if (why.empty()) {
        outcome.reached = true;
        outcome.best = entry.candidate;
        outcome.measured = std::move(measured);
        return {};
    }
    outcome.runners_up.push_back(fmt::format("{}: {}", in_words(entry.candidate), why));
    say(fmt::format("  not good enough: {}", why));
    // The laws once more, by as much as they were off.
    const sea::MeasuredError& last = measured.back();
    Expected most = allowed();
    if (!(last.total_m * margin <= target_.height_error_m))
        most.error_m = target_.height_error_m / margin * entry.candidate.expected_m / last.total_m;
    if (target_.slope_error && !(last.slope_rms * margin <= *target_.slope_error))
        most.slope_rms =
            *target_.slope_error / margin * entry.candidate.expected_slope / last.slope_rms;
    const std::size_t budgets = std::min(*entry.budget, budgets_within(entry.layout, most));
    return budgets == 0 ? Result<void>() : offer(entry.layout, budgets);
}

/// The best that can be had within the limits: layouts in the order of what they leave out, each with the
/// smallest budget that the limits allow, until what the next one leaves out alone is worse.
Result<void> Search::most_accurate(Outcome& outcome) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < laid_.size(); ++i)
        if (!target_.budget_ms || at_least_[i].work_ms() <= *target_.budget_ms)
            order.push_back(i);
    std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
        return laid_[a].missing_m != laid_[b].missing_m
                   ? laid_[a].missing_m < laid_[b].missing_m
                   : at_least_[a].work_ms() < at_least_[b].work_ms();
    });
    const bool limited = target_.budget_ms || target_.bytes_per_s;
    double best_m = std::numeric_limits<double>::infinity();
    for (const std::size_t layout : order) {
        if (sigmas_ * laid_[layout].missing_m >= best_m)
            break;
        // The first budget that is not too dear; without limits the smallest that there is.
        std::size_t low = 0, high = limited ? space_.height_errors_m.size() : 0;
        while (low < high) {
            const std::size_t middle = (low + high) / 2;
            SEAWAY_TRY_LET(const std::optional<Candidate> c, priced(layout, middle));
            if (c && !too_dear(c->price))
                high = middle;
            else
                low = middle + 1;
        }
        if (low == space_.height_errors_m.size())
            continue;
        SEAWAY_TRY_LET(const std::optional<Candidate> c, priced(layout, low));
        if (c && c->expected_m < best_m) {
            best_m = c->expected_m;
            outcome.best = *c;
        }
        // Layouts that leave out the same differ by little, and each takes seconds.
        if (!limited && best_m < 1.2 * sigmas_ * laid_[layout].missing_m)
            break;
    }
    if (!std::isfinite(best_m))
        return {};
    return measure_best(outcome, limited ? options_.sampling : best_sampling);
}

Result<bool> Search::best_slopes(Outcome& outcome) {
    const auto best = std::min_element(least_slope_.begin(), least_slope_.end());
    if (!target_.slope_error || target_.budget_ms || target_.bytes_per_s ||
        best == least_slope_.end() || !std::isfinite(*best))
        return false;
    // The cheapest of those that are as good: the others have more points and no better slopes.
    std::size_t layout = 0;
    for (std::size_t i = 1; i < least_slope_.size(); ++i)
        if (least_slope_[i] <= as_good * *best &&
            (least_slope_[layout] > as_good * *best ||
             at_least_[i].work_ms() < at_least_[layout].work_ms()))
            layout = i;
    SEAWAY_TRY_LET(const std::optional<Candidate> candidate, priced(layout, 0));
    if (!candidate)
        return false;
    outcome.best = *candidate;
    SEAWAY_TRY(measure_best(outcome, best_sampling));
    return true;
}

Result<void> Search::measure_best(Outcome& outcome, const Sampling& sampling) {
    say(fmt::format("measuring the most accurate: {}", in_words(outcome.best)));
    TuneOptions few = options_;
    few.sampling = sampling;
    SEAWAY_TRY_LET(const sea::MeasuredError error,
                   measure_error(with_candidate(scene_, outcome.best), "as given",
                                 target_.percentile, few, devices_));
    outcome.measured = {error};
    return {};
}

/// Its budgets, by the laws.
Result<void> Search::look_at(std::size_t layout) {
    if (++looked_at_ % layouts_a_line == 0)
        say(fmt::format("looked at {} layouts, priced {}", looked_at_, priced_));
    return bound(layout, budgets_within(layout, allowed()));
}

Result<Outcome> Search::run() {
    for (Layout& layout : layouts(space_, scene_.cascades.front().length_m)) {
        const double missing_m = missing(layout);
        laid_.push_back({std::move(layout), missing_m});
        SEAWAY_TRY_LET(const Price price,
                       prices_.at_least(laid_.back().layout.cascades, scene_, nullptr));
        at_least_.push_back(price);
        if (sigmas_ * missing_m * margin <= target_.height_error_m &&
            !(target_.budget_ms && price.work_ms() > *target_.budget_ms))
            queue_.push({price.work_ms(), laid_.size() - 1});
    }
    least_slope_.assign(laid_.size(), std::numeric_limits<double>::infinity());
    Outcome outcome;
    outcome.layouts = static_cast<int>(queue_.size());
    say(fmt::format("{} of {} layouts hold enough waves; the cheapest costs {:.1f} ms/s or more",
                    outcome.layouts, laid_.size(), queue_.empty() ? 0.0 : queue_.top().price_ms));
    while (!queue_.empty() && !outcome.reached) {
        const Entry entry = queue_.top();
        queue_.pop();
        if (entry.budget)
            SEAWAY_TRY(try_candidate(entry, outcome));
        else if (entry.budgets)
            SEAWAY_TRY(offer(entry.layout, *entry.budgets));
        else
            SEAWAY_TRY(look_at(entry.layout));
    }
    if (!outcome.reached) {
        SEAWAY_TRY_LET(const bool slopes, best_slopes(outcome));
        if (!slopes)
            SEAWAY_TRY(most_accurate(outcome));
    }
    if (!outcome.measured.empty())
        outcome.limits = {outcome.measured.front().waves_left_out_m,
                          outcome.measured.front().rms_m};
    outcome.priced = priced_;
    outcome.tried = tried_;
    return outcome;
}

} // namespace

Result<Outcome> tune(const sea::Scene& scene, const Target& target, const TuneSpace& space,
                     const TuneOptions& options, Prices& prices, Devices& devices) {
    SEAWAY_TRY_LET(Outcome outcome, Search(scene, target, space, options, prices, devices).run());
    if (outcome.reached || !(target.budget_ms || target.bytes_per_s))
        return outcome;
    Target alone = target;
    alone.budget_ms = alone.bytes_per_s = std::nullopt;
    SEAWAY_TRY_LET(const Outcome without,
                   Search(scene, alone, space, options, prices, devices).run());
    if (without.reached)
        outcome.without_limits = without.best;
    return outcome;
}

} // namespace seaway::bench
