// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/simulation.h"

#include <algorithm>
#include <utility>

#include "server/host/refusal.h"

namespace seaway::server {

using sea::TimeUs;

Result<std::unique_ptr<Simulation>> Simulation::start(RunningSeaPtr sea,
                                                      const SynthesizerFactory& factory,
                                                      const Subscriptions& subscriptions,
                                                      std::function<TimeUs()> now,
                                                      SimulationEvents events) {
    SEAWAY_TRY_LET(
        std::unique_ptr<RebuiltSynthesizer> device,
        RebuiltSynthesizer::start(factory, sea->realization, sea->epoch, events.on_warning));
    std::unique_ptr<Simulation> simulation(new Simulation(
        std::move(sea), std::move(device), subscriptions, std::move(now), std::move(events)));
    simulation->thread_ = std::thread([self = simulation.get()] { self->run(); });
    return simulation;
}

Simulation::Simulation(RunningSeaPtr sea, std::unique_ptr<RebuiltSynthesizer> device,
                       const Subscriptions& subscriptions, std::function<TimeUs()> now,
                       SimulationEvents events)
    : sea_(std::move(sea)), subscriptions_(subscriptions), now_(std::move(now)),
      events_(std::move(events)), source_(sea_, std::move(device)), schedule_(sea_->budget) {}

Simulation::~Simulation() {
    stopping_ = true;
    questions_.wake();
    if (thread_.joinable())
        thread_.join();
}

void Simulation::run() {
    while (!stopping_ && !source_.failure())
        if (!publish_due())
            work_on_a_question();
    if (source_.failure() && events_.on_failure)
        events_.on_failure(source_.failure()->message);
    questions_.close(source_.failure().value_or(Error{Refusal::gone, "the server stops"}));
}

bool Simulation::publish_due() {
    const Schedule::Due due = schedule_.take_due(plan(), now_());
    if (due.keyframes.empty())
        return false;
    const auto made = source_.keyframes(due.keyframes, Walk::stream);
    if (!made)
        return false;
    for (const sea::KeyframePtr& keyframe : *made)
        if (events_.on_keyframe)
            events_.on_keyframe(keyframe);
    keyframes_published_ += made->size();
    keyframes_skipped_ += due.left_out;
    return true;
}

void Simulation::work_on_a_question() {
    if (source_.failure())
        return;
    std::optional<TimeUs> wait_us = schedule_.next_due_us(plan());
    if (wait_us)
        wait_us = std::max<TimeUs>(*wait_us - now_(), 1);
    std::optional<Question> question = questions_.take(wait_us);
    if (question && !question->slice())
        questions_.put_back(std::move(*question));
}

SimulationCounters Simulation::counters() const {
    const KeyframeSource::Report report = source_.report();
    return {report.synthesis,   report.store,       keyframes_published_,
            keyframes_skipped_, questions_.asked(), report.device_rebuilds};
}

// ---- questions -----------------------------------------------------------------------------

void Simulation::fetch(std::vector<TimeUs> times_us, const Demand& demand, Fetched done) {
    for (const TimeUs time_us : times_us)
        if (const Result<void> fine = check_time(time_us); !fine)
            return done(fine.error());
    questions_.ask({[this, times_us = std::move(times_us), demand, done] {
                        done(source_.keyframes(keyframes_around(sea_->budget, times_us, demand),
                                               Walk::questions));
                        return true;
                    },
                    done});
}

void Simulation::fetch_current(const Demand& demand, Fetched done) {
    questions_.ask({[this, demand, done] {
                        done(source_.keyframes(schedule_.current(demand, now_()), Walk::questions));
                        return true;
                    },
                    done});
}

void Simulation::answer(std::vector<sea::QueryPoint> points, bool exact, Answered done) {
    for (const sea::QueryPoint& point : points)
        if (const Result<void> fine = check_point(point); !fine)
            return done(fine.error());
    auto batch = std::make_shared<PointQuestion>(std::move(points));
    questions_.ask({[this, batch, exact, done] {
                        if (exact) {
                            batch->sum_exactly(*sea_);
                        } else if (const Result<void> sampled = batch->sample(source_); !sampled) {
                            done(sampled.error());
                            return true;
                        }
                        if (batch->complete())
                            done(batch->take_answers());
                        return batch->complete();
                    },
                    done});
}

void Simulation::surface(TimeUs time_us, Surfaced done) {
    if (const Result<void> fine = check_time(time_us); !fine)
        return done(fine.error());
    questions_.ask({[this, time_us, done] {
                        const auto span = source_.surface_around(time_us);
                        done(span ? Result<SurfacePtr>(span->surface) : span.error());
                        return true;
                    },
                    done});
}

} // namespace seaway::server
