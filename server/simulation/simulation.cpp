// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/simulation.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "server/host/refusal.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

Error busy(std::string why) {
    Error error{Refusal::busy, std::move(why)};
    error.retry_after_ms = 1000;
    return error;
}

} // namespace

Result<std::unique_ptr<Simulation>>
Simulation::start(SeaCoursePtr course, const SynthesizerFactory& factory,
                  const Subscriptions& subscriptions, SimulationClock clock,
                  SimulationEvents events, WorkBudget budget, MemoryPtr memory) {
    SEAWAY_TRY_LET(std::unique_ptr<RebuiltSynthesizer> device,
                   RebuiltSynthesizer::start(factory, course->first()->realization,
                                             course->first()->epoch, events.on_warning));
    std::unique_ptr<Simulation> simulation(
        new Simulation(std::move(course), std::move(device), subscriptions, std::move(clock),
                       std::move(events), budget, std::move(memory)));
    simulation->thread_ = std::thread([self = simulation.get()] { self->run(); });
    return simulation;
}

Simulation::Simulation(SeaCoursePtr course, std::unique_ptr<RebuiltSynthesizer> device,
                       const Subscriptions& subscriptions, SimulationClock clock,
                       SimulationEvents events, WorkBudget budget, MemoryPtr memory)
    : course_(std::move(course)), subscriptions_(subscriptions), clock_(std::move(clock)),
      events_(std::move(events)), memory_(std::move(memory)),
      source_(course_, std::move(device), *memory_), prices_(course_), schedule_(*course_),
      streamed_foam_(*course_->first(), source_, schedule_),
      fetch_room_(memory_->room(MemoryUse::fetches)),
      questions_(budget, memory_->room(MemoryUse::points)) {
    fetch_room_->on_freed([this] { questions_.wake(); });
}

Simulation::~Simulation() {
    fetch_room_->on_freed(nullptr);
    stopping_ = true;
    questions_.wake();
    if (thread_.joinable())
        thread_.join();
}

EffectPlan Simulation::plan(TimeUs now_us) const {
    const RunningSeaPtr sea = course_->at(now_us);
    return plan_effects(sea->offered, subscriptions_, sea->budget);
}

void Simulation::run() {
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
    if (source_.failure() && events_.on_failure)
        events_.on_failure(source_.failure()->message);
    questions_.close(source_.failure().value_or(Error{Refusal::gone, "the server stops"}));
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
    if (now < trimmed_ + trim_interval)
        return;
    trimmed_ = now;
    trims_left_ = std::max(trims_left_ - 1, 0);
    (void)source_.trim();
    if (events_.on_trim)
        events_.on_trim();
}

bool Simulation::work_on_stream() {
    heartbeat_.works();
    if (!streaming_) {
        const TimeUs now_us = clock_.now();
        schedule_.hurry(clock_.hurry());
        streamed_plan_ = streamed_foam_.carried(plan(now_us), subscriptions_, now_us);
        Schedule::Due due = schedule_.take_due(streamed_plan_, now_us);
        if (due.keyframes.empty())
            return false;
        keyframes_skipped_ += due.left_out;
        streaming_.emplace(std::move(due.keyframes), Walk::stream);
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
    for (const sea::KeyframePtr& keyframe : keyframes)
        if (events_.on_keyframe)
            events_.on_keyframe(keyframe);
    keyframes_published_ += keyframes.size();
}

void Simulation::work_on_a_question(bool more) {
    std::optional<TimeUs> wait_us = 0;
    if (!more) {
        wait_us = schedule_.next_due_us(streamed_plan_);
        if (wait_us)
            wait_us = clock_.wait_us(*wait_us);
        if (wait_us)
            wait_us = std::max<TimeUs>(*wait_us, 1);
        if (trims_left_ > 0 || source_.holds_keyframes()) {
            constexpr TimeUs trim_us = std::chrono::microseconds(trim_interval).count();
            wait_us = std::min(wait_us.value_or(trim_us), trim_us);
        }
    }
    heartbeat_.rests();
    std::optional<Question> question = questions_.take(wait_us);
    if (!question)
        return;
    trims_left_ = trims_after_work;
    heartbeat_.works();
    if (question->asker.gone())
        question->refuse({Refusal::gone, "nobody waits for the answer"});
    else if (!answered(*question))
        return questions_.put_back(*std::move(question));
    questions_.over(*question);
}

bool Simulation::answered(Question& question) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    bool done = true;
    try {
        done = question.slice();
    } catch (const std::bad_alloc&) {
        refuse_surely(question, busy("there is no memory for this now, try again later"));
    } catch (const std::system_error& error) { // a thread that could not be started
        refuse_surely(question, busy(fmt::format("the system gives no more: {}, try again later",
                                                 error.code().message())));
    }
    questions_.spent(question,
                     std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    return done;
}

void Simulation::refuse_surely(const Question& question, const Error& why) {
    for (int attempt = 0; attempt < 100; ++attempt) {
        try {
            return question.refuse(why);
        } catch (const std::bad_alloc&) { // others give some back soon
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }
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

Question Simulation::keyframe_question(std::function<std::vector<KeyframeRequest>()> wanted,
                                       Walk walk, std::function<bool()> ready, Fetched done,
                                       const Asker& asker) {
    auto job = std::make_shared<std::optional<KeyframeJob>>();
    const auto slice = [this, job, wanted = std::move(wanted), walk, done] {
        if (!*job)
            job->emplace(wanted(), walk, fetch_room_);
        const Result<bool> made = source_.work_on(**job);
        if (!made) {
            done(made.error());
            return true;
        }
        if (*made) {
            FetchedKeyframes part{(*job)->take()};
            part.last = (*job)->complete();
            done(std::move(part));
        }
        return (*job)->complete();
    };
    return {slice, done, asker,
            [job, ready = std::move(ready)] { return ready() && !(*job && (*job)->waits()); }};
}

void Simulation::fetch(std::vector<TimeUs> times_us, const Demand& demand, Fetched done,
                       const Asker& asker) {
    for (const TimeUs time_us : times_us)
        if (const Result<void> fine = check_time(time_us); !fine)
            return done(fine.error());
    const double price_us = prices_.fetch_us(times_us, demand, holding());
    Question question =
        keyframe_question([this, times_us = std::move(times_us),
                           demand] { return keyframes_around(*course_, times_us, demand); },
                          Walk::questions, [] { return true; }, std::move(done), asker);
    question.price_us = price_us;
    question.prompt = price_us <= prices_.prompt_us();
    questions_.ask(std::move(question));
}

void Simulation::fetch_current(const Demand& demand, Fetched done, const Asker& asker) {
    // Has no price of its own: it is what a subscription begins with, and mostly held.
    Question question = keyframe_question(
        [this, demand] { return schedule_.current(demand, clock_.now()); }, Walk::starts,
        [this, demand] { return !streamed_foam_.starts(demand); }, std::move(done), asker);
    question.prompt = true;
    questions_.ask(std::move(question));
}

void Simulation::answer(std::vector<sea::QueryPoint> points, bool exact, Answered done,
                        const Asker& asker) {
    for (const sea::QueryPoint& point : points)
        if (const Result<void> fine = check_point(point); !fine)
            return done(fine.error());
    const double price_us = exact ? prices_.exact_us(points) : prices_.points_us(points, holding());
    const std::size_t bytes = PointQuestion::bytes_of(points.size());
    auto batch =
        std::make_shared<PointQuestion>(std::move(points), price_us <= prices_.prompt_us());
    questions_.ask({.slice =
                        [this, batch, exact, done] {
                            if (exact) {
                                batch->sum_exactly(*course_, over_after(points_slice));
                            } else if (const Result<void> sampled =
                                           batch->sample(source_, over_after(points_slice));
                                       !sampled) {
                                done(sampled.error());
                                return true;
                            }
                            if (batch->complete())
                                done(batch->take_answers());
                            return batch->complete();
                        },
                    .refuse = done,
                    .asker = asker,
                    .ready = [this, batch] { return !batch->waits(source_); },
                    .price_us = price_us,
                    .prompt = price_us <= prices_.prompt_us(),
                    .bytes = bytes});
}

void Simulation::surface(TimeUs time_us, Surfaced done, const Asker& asker) {
    if (const Result<void> fine = check_time(time_us); !fine)
        return done(fine.error());
    const double price_us = prices_.surface_us(time_us, holding());
    auto job = std::make_shared<SurfaceJob>(time_us);
    questions_.ask({.slice =
                        [this, job, done] {
                            const Result<bool> there = source_.work_on(*job);
                            if (!there)
                                done(there.error());
                            else if (*there)
                                done(job->surface());
                            return !there || *there;
                        },
                    .refuse = done,
                    .asker = asker,
                    .ready = [this, job] { return !source_.waits(*job); },
                    .price_us = price_us});
}

} // namespace seaway::server
