// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/sea_course.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "sea/scene/weather.h"
#include "sea/waves/transition.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

constexpr TimeUs ever_us = std::numeric_limits<TimeUs>::max();
constexpr TimeUs always_us = std::numeric_limits<TimeUs>::min();

/// Waves run alike in both, and have no clocks of their own.
bool run_alike(const sea::SeaState& a, const sea::SeaState& b) {
    const auto stylised = [](const sea::SeaState& sea) {
        return std::ranges::any_of(sea.systems, [](const sea::WaveSystem& system) {
            return std::holds_alternative<sea::SineRamps>(system);
        });
    };
    return a.depth_m == b.depth_m && a.gravity_mps2 == b.gravity_mps2 &&
           a.surface_tension == b.surface_tension && !stylised(a) && !stylised(b);
}

template <class Sea>
Sea made(Result<Sea> sea) {
    SEAWAY_CHECK(sea.has_value(), "a sea that was checked when it was added can be made");
    return *std::move(sea);
}

/// Those that may be longer than their cascade's band.
bool gives_waves(const sea::SeaState& sea) {
    return std::ranges::any_of(sea.systems, [](const sea::WaveSystem& system) {
        return std::holds_alternative<sea::ExplicitModes>(system) ||
               std::holds_alternative<sea::SineRamps>(system);
    });
}

} // namespace

SeaCourse::SeaCourse(RunningSeaPtr first) : first_(std::move(first)) {
    changes_.push_back(
        std::make_shared<const Change>(Change{0, always_us, always_us, first_->scene}));
}

// The last one first: each holds the one before it, and thousands would end one within the other.
SeaCourse::~SeaCourse() {
    while (!changes_.empty())
        changes_.pop_back();
}

Result<std::shared_ptr<SeaCourse>> SeaCourse::begin(const sea::Scene& scene) {
    SEAWAY_TRY_LET(RunningSeaPtr first, make_running_sea(scene, 1));
    auto course = std::make_shared<SeaCourse>(std::move(first));
    const auto name_of = [&](std::size_t row) {
        return fmt::format("{}: weather[{}]", scene.source, row + 1);
    };
    SEAWAY_TRY_LET(std::vector<Row> rows, course->timetable(scene, always_us, ever_us, name_of));
    course->append(std::move(rows), scene.weather.size());
    return course;
}

Result<void> SeaCourse::check_next(const sea::Scene& from, const sea::Scene& to) const {
    SEAWAY_TRY(sea::check_glide(from, to));
    // Seas are made days later, when a file may have gone.
    const std::string& certificate = to.accuracy.certificate.name;
    if (!certificate.empty() && certificate != first_->scene.accuracy.certificate.name)
        return Error{"accuracy.certificate cannot change while the sea runs: restart the server "
                     "with the other scene"};
    SEAWAY_TRY_LET(const sea::Realization waves, sea::realize_clocks(to));
    const auto tile = [](const sea::CascadeModes& modes) {
        return std::pair(modes.spec.length_m, modes.spec.size);
    };
    const auto& tiles = first_->realization->cascades;
    if (!std::ranges::equal(waves.cascades, tiles, {}, tile, tile))
        return Error{
            fmt::format("its explicit or stylised waves need other tiles than the {} that run: "
                        "restart the server with the other scene",
                        tiles.size())};
    return {};
}

Result<std::vector<SeaCourse::Row>> SeaCourse::timetable(const sea::Scene& scene, TimeUs from_us,
                                                         TimeUs until_us,
                                                         const NameOfRow& name_of) const {
    sea::Scene begins = scene;
    std::erase_if(begins.weather, [until_us](const sea::WeatherChange& row) {
        return sea::us_from_seconds(row.at_s) >= until_us;
    });
    SEAWAY_TRY_LET(std::vector<sea::Scene> scenes, sea::weather_scenes(begins));
    std::vector<Row> rows;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const sea::WeatherChange& row = scene.weather[i];
        const TimeUs start_us = sea::us_from_seconds(row.at_s);
        if (start_us < from_us)
            return Error{fmt::format("{}: at_s is {}, the sea is there only at {} s", name_of(i),
                                     row.at_s, sea::seconds_from_us(from_us))};
        const sea::Scene& before = rows.empty() ? scene : rows.back().scene;
        if (const Result<void> fine = check_next(before, scenes[i]); !fine)
            return Error{fmt::format("{}: {}", name_of(i), fine.error().message)};
        if (const Result<void> fine = check_tellable(scenes[i]); !fine)
            return Error{fmt::format("{}: {}", name_of(i), fine.error().message)};
        rows.push_back(
            {start_us, start_us + sea::us_from_seconds(row.over_s), std::move(scenes[i])});
    }
    return rows;
}

Result<std::vector<SeaCourse::Row>> SeaCourse::rows_of(const sea::Scene& scene, TimeUs start_us,
                                                       TimeUs end_us, TimeUs until_us) const {
    SEAWAY_CHECK(start_us < end_us, "a change takes some time");
    if (start_us >= until_us)
        return std::vector<Row>{};
    const auto [from, stay] = [&] {
        const std::scoped_lock lock(mutex_);
        const auto before = change_before(start_us);
        return std::pair(*before, static_cast<std::size_t>(before - changes_.begin()) + 1);
    }();
    SEAWAY_TRY(check_next(from->scene, scene));
    // Of a scene that was sent, or of one of before whose first rows are over: neither has a file whose rows it could count.
    const auto name_of = [&](std::size_t row) {
        return fmt::format("the row of its weather that begins at {} s", scene.weather[row].at_s);
    };
    SEAWAY_TRY_LET(std::vector<Row> rows, timetable(scene, end_us, until_us, name_of));
    rows.insert(rows.begin(), {start_us, end_us, scene});
    if (stay + rows.size() > changes_max)
        return Error{CourseError::full,
                     fmt::format("the log is full: it counts {} changes, this one would add {} "
                                 "with the rows of its timetable; allowed: at most {}",
                                 stay, rows.size(), changes_max)};
    return rows;
}

Result<void> SeaCourse::check(const sea::Scene& scene, TimeUs start_us, TimeUs end_us) const {
    SEAWAY_TRY(rows_of(scene, start_us, end_us, ever_us));
    return {};
}

Result<void> SeaCourse::add(const sea::Scene& scene, TimeUs start_us, TimeUs end_us,
                            TimeUs until_us) {
    SEAWAY_TRY_LET(std::vector<Row> rows, rows_of(scene, start_us, end_us, until_us));
    append(std::move(rows), 1 + scene.weather.size());
    return {};
}

void SeaCourse::append(std::vector<Row> rows, std::size_t changes) {
    const std::scoped_lock lock(mutex_);
    // What may find no memory comes first: all of it is there, or nothing.
    Changes added;
    added.reserve(rows.size());
    for (Row& row : rows) {
        const ChangePtr from = added.empty() ? *change_before(row.start_us) : added.back();
        const bool chained = from->chained || !run_alike(first_->scene.sea, row.scene.sea);
        const auto number = static_cast<std::uint32_t>(last_number_ + added.size() + 1);
        added.push_back(std::make_shared<const Change>(
            Change{number, row.start_us, row.end_us, std::move(row.scene), from,
                   row.start_us < from->end_us, chained}));
    }
    if (changes_.size() + added.size() > changes_.capacity())
        changes_.reserve(std::max(changes_.size() + added.size(), 2 * changes_.capacity()));
    while (!added.empty() && changes_.back()->start_us >= added.front()->start_us)
        changes_.pop_back();
    for (ChangePtr& change : added) {
        if (gives_waves(change->scene.sea))
            gives_waves_from_us_ = std::min(gives_waves_from_us_.load(), change->start_us);
        changes_.push_back(std::move(change));
    }
    last_number_ += static_cast<std::uint32_t>(changes);
}

SeaCourse::Changes::const_iterator SeaCourse::change_at(TimeUs time_us) const {
    return std::prev(std::ranges::upper_bound(
        changes_, time_us, {}, [](const ChangePtr& change) { return change->start_us; }));
}

SeaCourse::Changes::const_iterator SeaCourse::change_before(TimeUs time_us) const {
    return std::prev(std::ranges::lower_bound(
        changes_, time_us, {}, [](const ChangePtr& change) { return change->start_us; }));
}

SeaCourse::Changes::const_iterator SeaCourse::change_of(std::uint32_t epoch) const {
    SEAWAY_CHECK(epoch >= 1 && epoch <= 2 * last_number_ + 1, "an epoch that there is");
    const auto found = std::ranges::lower_bound(
        changes_, epoch / 2, {}, [](const ChangePtr& change) { return change->number; });
    SEAWAY_CHECK(found != changes_.end(), "what never runs was taken over from");
    return found;
}

EpochWindow SeaCourse::window_of(Changes::const_iterator change, bool glides) const {
    const Change& held = **change;
    const auto next = std::next(change);
    const TimeUs until_us = next == changes_.end() ? ever_us : (*next)->start_us;
    return glides ? EpochWindow{held.epoch(true), held.start_us, std::min(held.end_us, until_us)}
                  : EpochWindow{held.epoch(false), held.end_us, until_us};
}

RunningSeaPtr SeaCourse::alive(std::uint32_t epoch) const {
    if (epoch == first_->epoch)
        return first_;
    const auto found = alive_.find(epoch);
    RunningSeaPtr sea = found == alive_.end() ? nullptr : found->second.lock();
    if (const auto kept = std::ranges::find(kept_, sea); sea && kept != kept_.end())
        std::rotate(kept, kept + 1, kept_.end());
    return sea;
}

RunningSeaPtr SeaCourse::sea_if_held(std::uint32_t epoch) const {
    const std::scoped_lock lock(mutex_);
    const ChangePtr& change = *change_of(epoch);
    RunningSeaPtr sea = alive(epoch);
    return sea || change->number == epoch / 2 ? sea : alive(change->epoch(is_glide(epoch)));
}

RunningSeaPtr SeaCourse::hold(RunningSeaPtr sea) const {
    const std::scoped_lock lock(mutex_);
    kept_.push_back(sea);
    if (kept_.size() > seas_kept)
        kept_.pop_front();
    std::erase_if(alive_, [](const auto& one) { return one.second.expired(); });
    alive_[sea->epoch] = sea;
    return sea;
}

RunningSeaPtr SeaCourse::sea(std::uint32_t epoch) const {
    if (RunningSeaPtr sea = sea_if_held(epoch))
        return sea;
    return made_with(std::unique_lock(making_), epoch);
}

RunningSeaPtr SeaCourse::sea_unless_making(std::uint32_t epoch) const {
    if (RunningSeaPtr sea = sea_if_held(epoch))
        return sea;
    std::unique_lock turn(making_, std::try_to_lock);
    return turn ? made_with(std::move(turn), epoch) : nullptr;
}

RunningSeaPtr SeaCourse::made_with(std::unique_lock<std::mutex> turn, std::uint32_t epoch) const {
    struct Making {
        const SeaCourse& course;
        std::unique_lock<std::mutex> turn;
        Making(const SeaCourse& of, std::unique_lock<std::mutex> own)
            : course(of), turn(std::move(own)) {
            course.is_making_ = true;
        }
        ~Making() { // also where there was no memory for it
            course.is_making_ = false;
            turn.unlock();
            course.tell_made();
        }
    } const making(*this, std::move(turn));
    Way way = way_to(epoch); // of no steps: made while this one waited
    for (const Step& step : way.steps)
        way.from = hold(make(step, way.from));
    return way.from;
}

void SeaCourse::when_made(std::function<void()> call) const {
    const std::scoped_lock lock(telling_);
    when_made_ = std::move(call);
}

void SeaCourse::tell_made() const {
    const std::scoped_lock lock(telling_);
    if (when_made_)
        when_made_();
}

SeaCourse::Way SeaCourse::way_to(std::uint32_t epoch) const {
    Way way;
    Step step{};
    {
        const std::scoped_lock lock(mutex_);
        const ChangePtr& change = *change_of(epoch);
        step = {change->epoch(is_glide(epoch)), change};
    }
    for (;;) {
        way.from = sea_if_held(step.epoch);
        if (way.from)
            break;
        way.steps.push_back(step);
        if (!is_glide(step.epoch))
            break;
        step = {step.change->epoch_before(), step.change->from};
    }
    std::ranges::reverse(way.steps);
    return way;
}

RunningSeaPtr SeaCourse::make(const Step& step, const RunningSeaPtr& from) const {
    const Change& change = *step.change;
    if (!is_glide(step.epoch))
        return steady(change);
    RunningSeaPtr to = sea_if_held(step.epoch + 1);
    if (!to)
        to = hold(steady(change));
    ++seas_made_;
    return made(make_glide(*from, *to, step.epoch, change.start_us, change.end_us));
}

RunningSeaPtr SeaCourse::steady(const Change& change) const {
    ++seas_made_;
    auto waves = std::make_shared<const sea::Realization>(made(sea::realize(change.scene)));
    if (change.chained)
        waves = made(sea::continued(*clocks_before(change), *waves, change.start_us));
    return make_running_sea(change.scene, change.epoch(false), std::move(waves),
                            certificate_of(change.scene));
}

sea::RealizationPtr SeaCourse::clocks_before(const Change& change) const {
    std::vector<PhaseStep> steps; // the last one first
    sea::RealizationPtr clocks;
    const sea::Scene* own = nullptr; ///< whose phases are its own
    for (const Change* step = &change; !clocks && !own; step = step->from.get()) {
        const Change& from = *step->from;
        steps.push_back(
            {step->number, &step->scene, step->start_us, step->end_us, step->from_glide});
        if (step->from_glide)
            continue;
        if (!from.chained)
            own = &from.scene;
        else
            clocks = phases_.of(from.number);
    }
    std::ranges::reverse(steps);
    return made(phases_.before(clocks ? clocks : made(own_clocks(*own)), steps));
}

void SeaCourse::find_phases() const {
    const std::scoped_lock turn(making_);
    ChangePtr last;
    {
        const std::scoped_lock lock(mutex_);
        last = changes_.back();
    }
    if (last->chained)
        (void)clocks_before(*last);
}

sea::CertificatePtr SeaCourse::certificate_of(const sea::Scene& scene) const {
    return scene.accuracy.certificate.name.empty() ? nullptr : first_->certificate;
}

RunningSeaPtr SeaCourse::at(TimeUs time_us) const {
    return sea(window_at(time_us).epoch);
}

EpochWindow SeaCourse::window_at(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    const auto change = change_at(time_us);
    return window_of(change, time_us < (*change)->end_us);
}

EpochWindow SeaCourse::window(std::uint32_t epoch) const {
    const std::scoped_lock lock(mutex_);
    const auto change = change_of(epoch);
    if ((*change)->number != epoch / 2)
        return {epoch, (*change)->start_us, (*change)->start_us};
    return window_of(change, is_glide(epoch));
}

std::vector<EpochWindow> SeaCourse::windows(TimeUs from_us, TimeUs until_us) const {
    std::vector<EpochWindow> found;
    const std::scoped_lock lock(mutex_);
    for (auto change = changes_.begin(); change != changes_.end(); ++change)
        for (const bool glides : {true, false})
            if (const EpochWindow window = window_of(change, glides);
                !window.empty() && window.end_us > from_us && window.start_us < until_us)
                found.push_back(window);
    return found;
}

int SeaCourse::glides_in_row(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    const Change* change = change_before(time_us)->get();
    int glides = 0;
    for (bool glide = time_us < change->end_us; glide; change = change->from.get()) {
        ++glides;
        glide = change->from_glide;
    }
    return glides;
}

std::vector<std::uint32_t> SeaCourse::origins(std::uint32_t epoch) const {
    std::vector<std::uint32_t> found;
    const std::scoped_lock lock(mutex_);
    const Change* change = change_of(epoch)->get();
    for (bool glides = is_glide(epoch); glides;) {
        const TimeUs start_us = change->start_us;
        change = change->from.get();
        found.push_back(change->epoch(start_us <= change->end_us));
        glides = start_us < change->end_us;
    }
    return found;
}

std::uint32_t SeaCourse::epochs() const {
    const std::scoped_lock lock(mutex_);
    return 2 * last_number_ + 1;
}

std::size_t SeaCourse::changes() const {
    const std::scoped_lock lock(mutex_);
    return changes_.size();
}

sea::Scene SeaCourse::scene_at(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    return (*change_at(time_us))->scene;
}

} // namespace seaway::server
