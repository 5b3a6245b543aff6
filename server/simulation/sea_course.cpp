// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/sea_course.h"

#include <algorithm>
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

bool gives_waves(const sea::SeaState& sea) {
    return std::ranges::any_of(sea.systems, [](const sea::WaveSystem& system) {
        return std::holds_alternative<sea::ExplicitModes>(system);
    });
}

} // namespace

SeaCourse::SeaCourse(RunningSeaPtr first) : first_(std::move(first)) {
    changes_.push_back({always_us, always_us, first_->scene});
    epochs_.push_back({always_us, ever_us, 0, false});
}

Result<std::shared_ptr<SeaCourse>> SeaCourse::begin(const sea::Scene& scene) {
    SEAWAY_TRY_LET(RunningSeaPtr first, make_running_sea(scene, 1));
    auto course = std::make_shared<SeaCourse>(std::move(first));
    const auto name_of = [&](std::size_t row) {
        return fmt::format("{}: weather[{}]", scene.source, row + 1);
    };
    SEAWAY_TRY_LET(std::vector<Change> rows, course->timetable(scene, always_us, name_of));
    course->append(std::move(rows));
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
        return Error{fmt::format("explicit waves need other tiles than the {} that run: restart "
                                 "the server with the other scene",
                                 tiles.size())};
    return {};
}

Result<std::vector<SeaCourse::Change>> SeaCourse::timetable(const sea::Scene& scene, TimeUs from_us,
                                                            const NameOfRow& name_of) const {
    SEAWAY_TRY_LET(std::vector<sea::Scene> scenes, sea::weather_scenes(scene));
    std::vector<Change> rows;
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

Result<std::vector<SeaCourse::Change>> SeaCourse::changes_to(const sea::Scene& scene,
                                                             TimeUs start_us, TimeUs end_us) const {
    SEAWAY_CHECK(start_us < end_us, "a change takes some time");
    SEAWAY_TRY(check_next(scene_at(start_us), scene));
    // Of a scene that was sent, or of one of before whose first rows are over: neither has a file whose rows it could count.
    const auto name_of = [&](std::size_t row) {
        return fmt::format("the row of its weather that begins at {} s", scene.weather[row].at_s);
    };
    SEAWAY_TRY_LET(std::vector<Change> changes, timetable(scene, end_us, name_of));
    changes.insert(changes.begin(), {start_us, end_us, scene});
    const std::scoped_lock lock(mutex_);
    if (changes_.size() + changes.size() > changes_max)
        return Error{fmt::format("the log holds {} changes; allowed: at most {}", changes_.size(),
                                 changes_max)};
    return changes;
}

Result<void> SeaCourse::check(const sea::Scene& scene, TimeUs start_us, TimeUs end_us) const {
    SEAWAY_TRY(changes_to(scene, start_us, end_us));
    return {};
}

Result<void> SeaCourse::add(const sea::Scene& scene, TimeUs start_us, TimeUs end_us) {
    SEAWAY_TRY_LET(std::vector<Change> changes, changes_to(scene, start_us, end_us));
    append(std::move(changes));
    return {};
}

void SeaCourse::append(std::vector<Change> changes) {
    const std::scoped_lock lock(mutex_);
    // What may find no memory comes first: all of it is there, or nothing.
    const std::size_t before = changes_.size(), epochs = epochs_.size() + 2 * changes.size();
    if (epochs > epochs_.capacity())
        epochs_.reserve(std::max(epochs, 2 * epochs_.capacity()));
    try {
        for (Change& change : changes)
            changes_.push_back(std::move(change));
    } catch (...) {
        changes_.resize(before);
        throw;
    }
    for (std::size_t i = before; i < changes_.size(); ++i)
        begin_epochs(i);
    gives_waves_later_ =
        gives_waves_later_ ||
        std::any_of(changes_.begin() + static_cast<std::ptrdiff_t>(before), changes_.end(),
                    [](const Change& change) { return gives_waves(change.scene.sea); });
}

void SeaCourse::begin_epochs(std::size_t number) {
    Change& change = changes_[number];
    change.chained =
        changes_[number - 1].chained || !run_alike(first_->scene.sea, change.scene.sea);
    for (const auto& [start_us, glides] :
         {std::pair(change.start_us, true), std::pair(change.end_us, false)}) {
        for (Epoch& earlier : epochs_)
            earlier.end_us = std::min(earlier.end_us, start_us);
        epochs_.push_back({start_us, ever_us, number, glides});
    }
}

std::uint32_t SeaCourse::epoch_at(TimeUs time_us, std::size_t epochs) const {
    while (epochs > 1 && epochs_[epochs - 1].start_us > time_us)
        --epochs;
    return static_cast<std::uint32_t>(epochs);
}

std::uint32_t SeaCourse::epoch_before(std::size_t change) const {
    return epoch_at(changes_[change].start_us, 2 * change - 1);
}

RunningSeaPtr SeaCourse::sea_if_held(std::uint32_t epoch) const {
    const std::scoped_lock lock(mutex_);
    SEAWAY_CHECK(epoch >= 1 && epoch <= epochs_.size(), "an epoch that there is");
    if (epoch == first_->epoch)
        return first_;
    const auto found = alive_.find(epoch);
    RunningSeaPtr sea = found == alive_.end() ? nullptr : found->second.lock();
    if (const auto kept = std::ranges::find(kept_, sea); sea && kept != kept_.end())
        std::rotate(kept, kept + 1, kept_.end());
    return sea;
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
    Way way = way_to(epoch); // of no epochs: made while this one waited
    for (const std::uint32_t one : way.epochs)
        way.from = hold(make(one, way.from));
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
    for (;;) {
        way.from = sea_if_held(epoch);
        if (way.from)
            break;
        way.epochs.push_back(epoch);
        const std::scoped_lock lock(mutex_);
        const Epoch& wanted = epochs_[epoch - 1];
        if (!wanted.glides)
            break;
        epoch = epoch_before(wanted.change);
    }
    std::ranges::reverse(way.epochs);
    return way;
}

RunningSeaPtr SeaCourse::make(std::uint32_t epoch, const RunningSeaPtr& from) const {
    Epoch wanted{};
    const Change* change = nullptr;
    {
        const std::scoped_lock lock(mutex_);
        wanted = epochs_[epoch - 1];
        change = &changes_[wanted.change];
    }
    if (!wanted.glides)
        return steady(wanted.change, epoch);
    RunningSeaPtr to = sea_if_held(epoch + 1);
    if (!to)
        to = hold(steady(wanted.change, epoch + 1));
    ++seas_made_;
    return made(make_glide(*from, *to, epoch, change->start_us, change->end_us));
}

RunningSeaPtr SeaCourse::steady(std::size_t change, std::uint32_t epoch) const {
    const Change* made_of = nullptr;
    {
        const std::scoped_lock lock(mutex_);
        made_of = &changes_[change];
    }
    ++seas_made_;
    auto waves = std::make_shared<const sea::Realization>(made(sea::realize(made_of->scene)));
    if (made_of->chained)
        waves = made(sea::continued(*clocks_before(change), *waves, made_of->start_us));
    return make_running_sea(made_of->scene, epoch, std::move(waves),
                            certificate_of(made_of->scene));
}

sea::RealizationPtr SeaCourse::clocks_before(std::size_t change) const {
    std::vector<PhaseStep> steps; // the last one first
    sea::RealizationPtr clocks;
    const sea::Scene* own = nullptr; ///< whose phases are its own
    {
        const std::scoped_lock lock(mutex_);
        while (!clocks && !own) {
            const Change& step = changes_[change];
            const Epoch& from = epochs_[epoch_before(change) - 1];
            steps.push_back({change, &step.scene, step.start_us, step.end_us, from.glides});
            change = from.change;
            if (from.glides)
                continue;
            if (!changes_[change].chained)
                own = &changes_[change].scene;
            else
                clocks = phases_.of(change);
        }
    }
    std::ranges::reverse(steps);
    return made(phases_.before(clocks ? clocks : made(own_clocks(*own)), steps));
}

sea::CertificatePtr SeaCourse::certificate_of(const sea::Scene& scene) const {
    return scene.accuracy.certificate.name.empty() ? nullptr : first_->certificate;
}

RunningSeaPtr SeaCourse::at(TimeUs time_us) const {
    return sea(window_at(time_us).epoch);
}

EpochWindow SeaCourse::window_at(TimeUs time_us) const {
    std::uint32_t epoch = 0;
    {
        const std::scoped_lock lock(mutex_);
        epoch = epoch_at(time_us, epochs_.size());
    }
    return window(epoch);
}

EpochWindow SeaCourse::window(std::uint32_t epoch) const {
    const std::scoped_lock lock(mutex_);
    SEAWAY_CHECK(epoch >= 1 && epoch <= epochs_.size(), "an epoch that there is");
    const Epoch& held = epochs_[epoch - 1];
    return {epoch, held.start_us, held.end_us};
}

std::vector<EpochWindow> SeaCourse::windows(TimeUs from_us, TimeUs until_us) const {
    std::vector<EpochWindow> found;
    const std::scoped_lock lock(mutex_);
    for (std::size_t i = 0; i < epochs_.size(); ++i) {
        const EpochWindow window{static_cast<std::uint32_t>(i + 1), epochs_[i].start_us,
                                 epochs_[i].end_us};
        if (!window.empty() && window.end_us > from_us && window.start_us < until_us)
            found.push_back(window);
    }
    std::ranges::sort(found, {}, &EpochWindow::start_us);
    return found;
}

int SeaCourse::glides_in_row(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    int glides = 0;
    for (std::uint32_t epoch = epoch_at(time_us, epochs_.size()); epochs_[epoch - 1].glides;
         epoch = epoch_before(epochs_[epoch - 1].change))
        ++glides;
    return glides;
}

std::vector<std::uint32_t> SeaCourse::origins(std::uint32_t epoch) const {
    std::vector<std::uint32_t> found;
    const std::scoped_lock lock(mutex_);
    for (bool glides = epochs_[epoch - 1].glides; glides;) {
        const Epoch& glide = epochs_[epoch - 1];
        const TimeUs start_us = glide.start_us;
        epoch = epoch_at(start_us - 1, 2 * glide.change - 1);
        found.push_back(epoch);
        glides = epochs_[epoch - 1].glides && epochs_[epoch].start_us > start_us;
    }
    return found;
}

std::uint32_t SeaCourse::epochs() const {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::uint32_t>(epochs_.size());
}

sea::Scene SeaCourse::scene_at(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    return changes_[epochs_[epoch_at(time_us, epochs_.size()) - 1].change].scene;
}

} // namespace seaway::server
