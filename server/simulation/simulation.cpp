// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/simulation.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/for_want_of_memory.h"
#include "base/thread_name.h"
#include "server/host/refusal.h"
#include "server/simulation/fetched_parts.h"
#include "server/simulation/slice.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

/// Questions wait for places in these.
constexpr MemoryUse awaited_rooms[] = {MemoryUse::fetches, MemoryUse::surfaces,
                                       MemoryUse::prompt_surfaces};

/// Of all threads together.
WorkBudget of_threads(WorkBudget each, int threads) {
    each.rate *= threads;
    return each;
}

} // namespace

Result<std::unique_ptr<Simulation>>
Simulation::start(SeaCoursePtr course, const SynthesizerFactory& factory,
                  const Subscriptions& subscriptions, SimulationClock clock,
                  SimulationEvents events, WorkBudget budget, MemoryPtr memory, int answer_threads,
                  Readback readback) {
    SEAWAY_TRY_LET(std::unique_ptr<RebuiltSynthesizer> device,
                   RebuiltSynthesizer::start(factory, course->first()->realization,
                                             course->first()->epoch, events.on_warning));
    std::unique_ptr<Simulation> simulation(new Simulation(
        std::move(course), std::move(device), subscriptions, std::move(clock), std::move(events),
        of_threads(budget, 1 + answer_threads), std::move(memory), readback));
    simulation->thread_ = std::thread([self = simulation.get()] { self->run(); });
    simulation->answer_threads_.start(answer_threads);
    return simulation;
}

Simulation::Simulation(SeaCoursePtr course, std::unique_ptr<RebuiltSynthesizer> device,
                       const Subscriptions& subscriptions, SimulationClock clock,
                       SimulationEvents events, WorkBudget budget, MemoryPtr memory,
                       Readback readback)
    : course_(std::move(course)), subscriptions_(subscriptions), clock_(std::move(clock)),
      events_(std::move(events)), memory_(std::move(memory)),
      source_(course_, std::move(device), *memory_, readback),
      surfaces_(course_, source_, *memory_), prices_(course_), schedule_(*course_),
      streamed_foam_(*course_->first(), source_, schedule_,
                     [this](const std::string& why) {
                         if (events_.on_warning)
                             events_.on_warning(why);
                     }),
      fetch_room_(memory_->room(MemoryUse::fetches)),
      questions_(budget, memory_->room(MemoryUse::points)) {
    for (const MemoryUse use : awaited_rooms)
        memory_->room(use)->on_freed([this] { questions_.wake(); });
    course_->when_made([this] { questions_.wake(); });
}

Simulation::~Simulation() {
    course_->when_made(nullptr);
    for (const MemoryUse use : awaited_rooms)
        memory_->room(use)->on_freed(nullptr);
    stopping_ = true;
    questions_.wake();
    if (thread_.joinable())
        thread_.join(); // it has closed the questions
    answer_threads_.join();
}

EffectPlan Simulation::plan(TimeUs now_us) const {
    const RunningSeaPtr sea = course_->at(now_us);
    return plan_effects(sea->offered, subscriptions_, sea->budget);
}

EffectPlan Simulation::plan() const {
    EffectPlan now = plan(clock_.now());
    now.questioned = source_.holds_asked_keyframes();
    return now;
}

void Simulation::run() {
    name_thread("sea-simulation");
    while (!stopping_ && !source_.failure()) {
        try {
            trim_now_and_then();
            const bool streamed = work_ahead();
            if (!source_.failure())
                work_on_a_question(streamed);
        } catch (const std::bad_alloc&) { // a question is lost; work_ahead() sees to itself
        }
    }
    heartbeat_.rests();
    // Nobody is behind this who would take what is thrown. Without memory for the reason who waits is told at least that this is the end.
    if (!tried_for_a_second([&] {
            questions_.close(source_.failure().value_or(Error{Refusal::gone, "the server stops"}));
        }))
        questions_.close(Error{Refusal::gone, "it is over"});
    if (source_.failure() && events_.on_failure)
        (void)tried_for_a_second([&] { events_.on_failure(source_.failure()->message); });
}

bool Simulation::work_ahead() {
    bool worked = false;
    try {
        for (int i = 0; i < stream_slices_ahead && !source_.failure() && work_on_stream(); ++i) {
            worked = true;
            ++stream_slices_;
        }
        if (!source_.failure() && streamed_foam_.walk(clock_.now())) {
            worked = true;
            ++stream_slices_;
        }
    } catch (const std::bad_alloc&) { // these keyframes are lost, the next ones may not be
        streaming_.reset();
        if (events_.on_warning)
            events_.on_warning("keyframes left out: there is no memory for them");
    }
    return worked;
}

void Simulation::trim_now_and_then() {
    const auto now = std::chrono::steady_clock::now();
    if (now < trimmed_ + memory_->trims_every())
        return;
    trimmed_ = now;
    if (source_.holds_keyframes())
        trims_left_ = trims_after_work;
    else if (trims_left_ > 0)
        --trims_left_;
    (void)source_.trim();
    if (++trims_ % trims_a_give_back == 0 && events_.on_trim)
        events_.on_trim();
}

bool Simulation::work_on_stream() {
    heartbeat_.works();
    if (!streaming_) {
        const TimeUs now_us = clock_.now();
        schedule_.hurry(clock_.hurry());
        streamed_plan_ = streamed_foam_.carried(plan(now_us), subscriptions_, now_us);
        Schedule::Due due = schedule_.take_due(*streamed_plan_, now_us);
        if (due.keyframes.empty())
            return false;
        keyframes_skipped_ += due.left_out;
        streaming_.emplace(std::move(due.keyframes), Walk::stream);
        streaming_rates_ = std::move(due.rates);
        streaming_published_ = 0;
    }
    const Result<bool> made = source_.work_on(*streaming_);
    if (made && *made)
        publish(streaming_->take());
    if (!made && !source_.failure() && events_.on_warning)
        events_.on_warning(fmt::format("keyframes left out: {}", made.error().message));
    if (!made || streaming_->complete())
        streaming_.reset();
    return true;
}

void Simulation::publish(const std::vector<sea::KeyframePtr>& keyframes) {
    for (const sea::KeyframePtr& keyframe : keyframes) {
        const RateSet rates = streaming_rates_[streaming_published_++];
        for (std::size_t rate = 0; rate < rates.size(); ++rate)
            if (rates[rate] && events_.on_keyframe)
                events_.on_keyframe(keyframe, rate);
    }
    keyframes_published_ += keyframes.size();
}

void Simulation::work_on_a_question(bool more) {
    std::optional<TimeUs> wait_us = 0;
    if (!more) {
        constexpr TimeUs plan_again_us = 10'000; // there was no memory for a first one
        wait_us =
            streamed_plan_ ? schedule_.next_due_us(*streamed_plan_) : clock_.now() + plan_again_us;
        if (wait_us)
            wait_us = clock_.wait_us(*wait_us);
        if (wait_us)
            wait_us = std::max<TimeUs>(*wait_us, 1);
        if (streamed_foam_.pauses()) {
            constexpr TimeUs pause_us =
                std::chrono::duration_cast<std::chrono::microseconds>(StreamedFoam::pause).count();
            wait_us = std::min(wait_us.value_or(pause_us), pause_us);
        }
        if (trims_left_ > 0 || source_.holds_keyframes()) {
            const TimeUs trim_us = std::chrono::microseconds(memory_->trims_every()).count();
            wait_us = std::min(wait_us.value_or(trim_us), trim_us);
        }
    }
    heartbeat_.rests();
    std::optional<Question> question = questions_.take(wait_us);
    if (!question)
        return;
    heartbeat_.works();
    work_on_slice(questions_, *std::move(question));
}

SimulationCounters Simulation::counters() const {
    const KeyframeSource::Report report = source_.report();
    return {report.synthesis,
            report.store,
            keyframes_published_,
            keyframes_skipped_,
            stream_slices_,
            questions_.asked(),
            questions_.over_budget(),
            questions_.bytes(),
            fetch_room_->held_bytes(),
            fetch_room_->held_bytes_most(),
            report.device_rebuilds};
}

// ---- questions -----------------------------------------------------------------------------

HoldingOf Simulation::holding() const {
    return [this](const KeyframeRequest& request) { return source_.holding(request); };
}

void Simulation::woken_for_work() {
    if (trims_left_.exchange(trims_after_work) == 0)
        questions_.wake(); // it sleeps until there is something to let go
}

void Simulation::ask(Question question) {
    woken_for_work();
    questions_.ask(std::move(question));
}

void Simulation::answer_at_once(Question question, const std::function<bool()>& slice) {
    // What it works, not for how long others hold its processor, which is when their threads would be no sooner there.
    const double start_s = thread_cpu_seconds();
    {
        const std::scoped_lock lock(at_once_mutex_);
        if (!at_once_.may_ask(steady_seconds()))
            return ask(std::move(question));
    }
    woken_for_work();
    std::optional<Question> mine = questions_.ask_or_take(std::move(question));
    if (!mine)
        return;
    work_on_slice(questions_, *std::move(mine), slice);
    const std::scoped_lock lock(at_once_mutex_);
    at_once_.take(1e6 * (thread_cpu_seconds() - start_s));
}

template <class Parts>
bool Simulation::work_on(KeyframeJob& job, Parts& parts, const Fetched& done) {
    const Result<bool> made = source_.work_on(job);
    if (!made) {
        done(made.error());
        return true;
    }
    if (!*made)
        return false;
    FetchedKeyframes part{parts.take()};
    const bool last = parts.complete();
    part.last = last;
    done(std::move(part));
    return last;
}

void Simulation::fetch(std::vector<TimeUs> times_us, const Demand& demand, Fetched done,
                       const Asker& asker) {
    for (const TimeUs time_us : times_us)
        if (const Result<void> fine = check_time(time_us); !fine)
            return done(fine.error());
    const double price_us =
        prices_.fetch_us(times_us, demand, [this](const KeyframeRequest& request) {
            return source_.holding_of_maps(request);
        });
    auto parts = std::make_shared<FetchedParts>(*course_, times_us, demand, fetch_room_);
    const auto slice = [this, parts, done] {
        if (parts->hand() == Hand::answers) {
            parts->make_some_sea();
            return false;
        }
        return parts->may_work() && work_on(parts->job(), *parts, done);
    };
    ask({.slice = slice,
         .refuse = done,
         .asker = asker,
         .ready = [parts] { return !parts->waits(); },
         .hand = [parts] { return parts->hand(); },
         .price_us = price_us,
         .prompt = price_us <= prices_.prompt_us()});
}

void Simulation::fetch_current(const Demand& demand, Fetched done, const Asker& asker) {
    // Has no price of its own: it is what a subscription begins with, and mostly held.
    auto job = std::make_shared<std::optional<KeyframeJob>>();
    const auto slice = [this, job, demand, done] {
        if (!*job)
            job->emplace(schedule_.current(demand, clock_.now()), Walk::starts, fetch_room_);
        return work_on(**job, **job, done);
    };
    const auto ready = [this, job, demand] {
        return !streamed_foam_.starts(demand) && !(*job && (*job)->waits());
    };
    ask({.slice = slice, .refuse = done, .asker = asker, .ready = ready, .prompt = true});
}

void Simulation::answer(PointsAsked asked, Answered done, const Asker& asker) {
    const std::span<const sea::QueryPoint> points = asked.points;
    for (const sea::QueryPoint& point : points)
        if (const Result<void> fine = check_point(point); !fine)
            return done(fine.error());
    const bool exact = asked.exact || !asked.z_m.empty();
    const std::size_t bytes = PointQuestion::bytes_of(points.size(), asked.z_m.size());
    if (static_cast<double>(points.size()) >
        prompt_points) // whose price takes milliseconds to find
        if (const std::optional<Error> refusal = questions_.why_not(asker, bytes))
            return done(*refusal);
    const std::uint32_t cascades = felt_cascades(*course_, points, asked.looking);
    const double price_us = exact ? prices_.exact_us(points, asked.z_m.size())
                                  : prices_.points_us(points, holding(), cascades);
    const bool prompt = price_us <= prices_.prompt_us();
    const bool few = prompt && static_cast<double>(points.size()) <= prompt_points;
    const bool looked_up = prompt && !exact && !points.empty();
    const bool again =
        looked_up && cascades == sea::all_cascades; // what comes is made ready for all waves
    const TimeUs last_us = again ? points.back().time_us : 0;
    const SurfaceUse use = few ? SurfaceUse::few : prompt ? SurfaceUse::prompt : SurfaceUse::batch;
    auto batch = std::make_shared<PointQuestion>(std::move(asked), use, cascades);
    const auto slice = [this, batch, exact, done](Make make) {
        if (batch->hand() == Hand::simulation) {
            const Result<void> made = batch->make_keyframes(surfaces_);
            if (!made)
                done(made.error());
            return !made;
        }
        if (exact)
            batch->sum_exactly(*course_, over_after(points_slice), sums_);
        else
            batch->sample(surfaces_, over_after(points_slice), make);
        if (batch->complete())
            done(batch->take_answers());
        return batch->complete();
    };
    Question question{.slice = [slice] { return slice(Make::what_lacks); },
                      .refuse = done,
                      .asker = asker,
                      .ready = [this, batch] { return !batch->waits(surfaces_, *course_); },
                      .hand = [batch] { return batch->hand(); },
                      .price_us = price_us,
                      .prompt = prompt,
                      .bytes = bytes};
    if (few && looked_up && price_us <= at_once_us)
        answer_at_once(std::move(question), [slice] { return slice(Make::nothing); });
    else
        ask(std::move(question));
    if (const auto time_us = again ? foresight_.asked(last_us, clock_.now()) : std::nullopt)
        make_ready(*time_us);
}

Question Simulation::surface_question(std::shared_ptr<SurfaceJob> job, Surfaced done,
                                      const Asker& asker) {
    return {.slice =
                [this, job, done] {
                    if (job->lacks_keyframes()) {
                        const Result<void> made = surfaces_.make_keyframes(*job);
                        if (!made)
                            done(made.error());
                        return !made;
                    }
                    const bool there = surfaces_.work_on(*job);
                    if (there)
                        done(job->surface());
                    return there;
                },
            .refuse = done,
            .asker = asker,
            .ready = [this, job] { return !surfaces_.waits(*job); },
            .hand = [job] { return job->lacks_keyframes() ? Hand::simulation : Hand::answers; }};
}

void Simulation::surface(TimeUs time_us, Surfaced done, const Asker& asker) {
    if (const Result<void> fine = check_time(time_us); !fine)
        return done(fine.error());
    Question question =
        surface_question(std::make_shared<SurfaceJob>(time_us), std::move(done), asker);
    question.price_us = prices_.surface_us(time_us, holding());
    ask(std::move(question));
}

void Simulation::make_ready(TimeUs time_us) {
    Question question = surface_question(
        std::make_shared<SurfaceJob>(time_us, SurfaceUse::ahead), [](const auto&) {},
        Asker(foreseer_));
    question.own = true;
    questions_.ask(std::move(question));
}

} // namespace seaway::server
