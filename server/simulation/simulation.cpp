// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/simulation.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace seaway::server {

using sea::TimeUs;

namespace {

/// Start of the keyframe interval that holds the time; also for times before the epoch.
TimeUs interval_start(TimeUs time_us, TimeUs interval_us) {
    const TimeUs rest = time_us % interval_us;
    return time_us - (rest < 0 ? rest + interval_us : rest);
}

std::vector<int> cascade_sizes(const RunningSea& sea) {
    std::vector<int> sizes;
    for (const sea::CascadeModes& modes : sea.realization->cascades)
        sizes.push_back(modes.spec.size);
    return sizes;
}

} // namespace

Result<std::unique_ptr<Simulation>> Simulation::start(RunningSeaPtr sea, SynthesizerFactory factory,
                                                      std::function<TimeUs()> now,
                                                      SimulationEvents events) {
    std::unique_ptr<Simulation> simulation(
        new Simulation(std::move(sea), std::move(factory), std::move(now), std::move(events)));
    if (Result<void> built = simulation->rebuild_device(); !built)
        return built.error();
    simulation->thread_ = std::thread([self = simulation.get()] { self->run(); });
    return simulation;
}

Simulation::Simulation(RunningSeaPtr sea, SynthesizerFactory factory, std::function<TimeUs()> now,
                       SimulationEvents events)
    : sea_(std::move(sea)), factory_(std::move(factory)), now_(std::move(now)),
      events_(std::move(events)), next_keyframe_us_(sea_->budget.cascades.size()),
      streaming_(sea_->budget.cascades.size()), streamed_foam_(*sea_), asked_foam_(*sea_),
      plan_(plan_effects(sea_->offered, {}, sea_->budget)), costs_(cascade_sizes(*sea_)) {}

Simulation::~Simulation() {
    {
        const std::scoped_lock lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable())
        thread_.join();
}

void Simulation::set_demand(std::uint64_t who, Demand demand) {
    {
        const std::scoped_lock lock(mutex_);
        if (demand.fields.empty() || demand.cascades == 0)
            demands_.erase(who);
        else
            demands_[who] = demand;
        std::vector<Demand> all;
        for (const auto& [id, one] : demands_)
            all.push_back(one);
        plan_ = plan_effects(sea_->offered, all, sea_->budget);
    }
    wake_.notify_all();
}

void Simulation::ask(Question question) {
    std::optional<Error> refused;
    {
        const std::scoped_lock lock(mutex_);
        if (ended_) {
            refused = ended_;
        } else if (questions_.size() >= questions_waiting_max) {
            refused = Error{Refusal::busy, fmt::format("{} questions wait already, try again later",
                                                       questions_waiting_max)};
        } else {
            ++counters_.questions;
            questions_.push_back(std::move(question));
        }
    }
    if (refused)
        return question.refuse(*refused);
    wake_.notify_all();
}

void Simulation::refuse_all_questions() {
    std::deque<Question> left;
    Error why{Refusal::gone, "the server stops"};
    {
        const std::scoped_lock lock(mutex_);
        if (!ended_)
            ended_ = why;
        why = *ended_;
        left.swap(questions_);
    }
    for (const Question& question : left)
        question.refuse(why);
}

void Simulation::run() {
    while (!failed_) {
        if (publish_due())
            continue;
        Question question;
        {
            std::unique_lock lock(mutex_);
            if (stopping_)
                break;
            if (questions_.empty()) {
                if (plan_.idle())
                    wake_.wait(lock);
                else
                    wake_.wait_for(lock, std::chrono::microseconds(
                                             std::max<TimeUs>(next_due_us() - now_(), 1)));
                continue;
            }
            question = std::move(questions_.front());
            questions_.pop_front();
        }
        // Unfinished ones go to the end: a large one delays small ones by a slice at a time.
        if (!question.slice()) {
            const std::scoped_lock lock(mutex_);
            questions_.push_back(std::move(question));
        }
    }
    refuse_all_questions();
}

TimeUs Simulation::lead_us(std::size_t cascade) const {
    return sea_->budget.cascades[cascade].interval_us + publish_lead_us;
}

TimeUs Simulation::next_due_us() const {
    TimeUs next = std::numeric_limits<TimeUs>::max();
    for (std::size_t c = 0; c < plan_.cascades.size(); ++c)
        if (!plan_.cascades[c].fields.empty())
            next = std::min(next, next_keyframe_us_[c] - lead_us(c));
    return next;
}

bool Simulation::publish_due() {
    const EffectPlan plan = this->plan();
    const TimeUs now_us = now_();
    std::vector<Wanted> due;
    std::uint64_t skipped = 0;
    for (std::size_t c = 0; c < plan.cascades.size(); ++c) {
        const auto& [fields, interval_us, transforms] = plan.cascades[c];
        const bool wanted = !fields.empty();
        TimeUs& next_us = next_keyframe_us_[c];
        if (wanted && !streaming_[c]) // the first subscriber fetches up to here for itself
            next_us = interval_start(now_us + lead_us(c), interval_us);
        streaming_[c] = wanted;
        if (!wanted || now_us < next_us - lead_us(c))
            continue;
        const TimeUs oldest_us = now_us - catch_up_us;
        if (next_us < oldest_us) {
            const TimeUs resumed_us = interval_start(now_us, interval_us);
            skipped += static_cast<std::uint64_t>((resumed_us - next_us) / interval_us);
            next_us = resumed_us;
        }
        due.push_back({static_cast<int>(c), next_us, fields});
        next_us += interval_us;
    }
    if (due.empty())
        return false;
    const Result<std::vector<sea::KeyframePtr>> made = keyframes(due, streamed_foam_);
    if (!made)
        return false; // this was the end
    for (const sea::KeyframePtr& keyframe : *made)
        if (events_.on_keyframe)
            events_.on_keyframe(keyframe);
    const std::scoped_lock lock(mutex_);
    counters_.keyframes_published += made->size();
    counters_.keyframes_skipped += skipped;
    return true;
}

RunningSeaPtr Simulation::sea() const {
    return sea_;
}

EffectPlan Simulation::plan() const {
    const std::scoped_lock lock(mutex_);
    return plan_;
}

EffectCosts Simulation::costs() const {
    const std::scoped_lock lock(mutex_);
    return costs_;
}

std::string Simulation::device() const {
    const std::scoped_lock lock(mutex_);
    return device_;
}

SimulationCounters Simulation::counters() const {
    const std::scoped_lock lock(mutex_);
    SimulationCounters counters = counters_;
    counters.store = store_.counters();
    return counters;
}

// ---- keyframes -----------------------------------------------------------------------------

Result<void> Simulation::rebuild_device() {
    synthesizer_.reset();
    Result<std::unique_ptr<Synthesizer>> made = factory_();
    if (!made)
        return made.error();
    if (Result<void> ready = (*made)->set_sea(sea_->realization, sea_->epoch); !ready)
        return ready.error();
    synthesizer_ = std::move(made).value();
    const std::scoped_lock lock(mutex_);
    device_ = synthesizer_->description();
    before_rebuild_ = counters_.synthesis;
    return {};
}

Result<std::vector<sea::KeyframePtr>>
Simulation::synthesize(std::span<const KeyframeRequest> requests,
                       std::span<const KeyframeRequest> asked) {
    Result<std::vector<sea::KeyframePtr>> made = Error{"there is no device"};
    for (int attempt = 0; attempt <= device_rebuilds_max; ++attempt) {
        if (synthesizer_)
            made = synthesizer_->synthesize(requests);
        if (made) {
            count_synthesis(asked);
            return made;
        }
        if (attempt == device_rebuilds_max)
            break;
        if (events_.on_warning)
            events_.on_warning(fmt::format("device failed, rebuilding it ({} of {}): {}",
                                           attempt + 1, device_rebuilds_max, made.error().message));
        if (Result<void> rebuilt = rebuild_device(); !rebuilt)
            made = rebuilt.error();
        const std::scoped_lock lock(mutex_);
        ++counters_.device_rebuilds;
    }
    return made;
}

void Simulation::count_synthesis(std::span<const KeyframeRequest> requests) {
    const SynthesisCounters device = synthesizer_->counters();
    const std::scoped_lock lock(mutex_);
    SynthesisCounters& total = counters_.synthesis;
    const SynthesisCounters before = total;
    total = {before_rebuild_.dispatches + device.dispatches,
             before_rebuild_.transforms + device.transforms,
             before_rebuild_.keyframes + device.keyframes,
             before_rebuild_.device_seconds + device.device_seconds};
    costs_.add(requests,
               {total.dispatches - before.dispatches, total.transforms - before.transforms,
                total.keyframes - before.keyframes, total.device_seconds - before.device_seconds});
}

Result<std::vector<sea::KeyframePtr>> Simulation::keyframes(std::span<const Wanted> wanted,
                                                            FoamMaps& foam) {
    std::vector<sea::KeyframePtr> found(wanted.size());
    std::vector<KeyframeRequest> missing;
    std::vector<std::size_t> place;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const auto& [cascade, time_us, fields] = wanted[i];
        found[i] = store_.find(cascade, time_us, fields);
        if (found[i])
            continue;
        missing.push_back({cascade, time_us, fields | store_.held(cascade, time_us)});
        place.push_back(i);
    }
    if (missing.empty())
        return found;
    Result<std::vector<sea::KeyframePtr>> made = compute(missing, foam);
    if (!made) {
        const Error why{Refusal::gone,
                        fmt::format("the device has failed for good: {}", made.error().message)};
        {
            const std::scoped_lock lock(mutex_);
            ended_ = why;
        }
        failed_ = true;
        if (events_.on_failure)
            events_.on_failure(made.error().message);
        return why;
    }
    for (std::size_t i = 0; i < made->size(); ++i) {
        store_.insert((*made)[i]);
        found[place[i]] = std::move((*made)[i]);
    }
    return found;
}

Result<std::vector<sea::KeyframePtr>> Simulation::compute(std::span<const KeyframeRequest> requests,
                                                          FoamMaps& foam) {
    std::vector<KeyframeRequest> synthesized(requests.begin(), requests.end());
    for (KeyframeRequest& request : synthesized)
        request.fields = foam_replaced(request.fields);
    Result<std::vector<sea::KeyframePtr>> made = synthesize(synthesized, requests);
    for (std::size_t i = 0; made && i < requests.size(); ++i) {
        if (!requests[i].fields.contains(sea::Field::foam))
            continue;
        Result<sea::KeyframePtr> foamy = add_foam((*made)[i], foam);
        if (!foamy)
            return foamy.error();
        (*made)[i] = std::move(foamy).value();
    }
    return made;
}

Result<sea::KeyframePtr> Simulation::add_foam(const sea::KeyframePtr& keyframe, FoamMaps& foam) {
    using Clock = std::chrono::steady_clock;
    const auto cascade = static_cast<std::size_t>(keyframe->cascade);
    const Clock::time_point start = Clock::now();
    Clock::duration synthesizing{};
    Result<sea::KeyframePtr> foamy =
        foam.add(keyframe, [&](TimeUs t_us) -> Result<sea::KeyframePtr> {
            const Clock::time_point begin = Clock::now();
            const KeyframeRequest past{keyframe->cascade, t_us, sea::foam_inputs};
            const KeyframeRequest asked{keyframe->cascade, t_us, {sea::Field::foam}};
            Result<std::vector<sea::KeyframePtr>> one = synthesize({&past, 1}, {&asked, 1});
            synthesizing += Clock::now() - begin;
            if (!one)
                return one.error();
            return one->front();
        });
    const std::chrono::duration<double> spent = Clock::now() - start - synthesizing;
    const std::scoped_lock lock(mutex_);
    costs_.add_seconds(cascade, sea::Field::foam, spent.count());
    return foamy;
}

std::vector<Simulation::Wanted> Simulation::around(TimeUs time_us, const Demand& demand) const {
    SEAWAY_CHECK(sea::in_time_range(time_us), "a time out of range is refused where it is asked");
    std::vector<Wanted> wanted;
    for (std::size_t c = 0; c < sea_->budget.cascades.size(); ++c) {
        if (!((demand.cascades >> c) & 1u))
            continue;
        const TimeUs interval_us = sea_->budget.cascades[c].interval_us;
        const TimeUs start_us = interval_start(time_us, interval_us);
        wanted.push_back({static_cast<int>(c), start_us, demand.fields});
        wanted.push_back({static_cast<int>(c), start_us + interval_us, demand.fields});
    }
    return wanted;
}

void Simulation::fetch(std::vector<TimeUs> times_us, Demand demand, Fetched done) {
    for (const TimeUs time_us : times_us)
        if (const Result<void> fine = check_time(time_us); !fine)
            return done(fine.error());
    ask({[this, times_us = std::move(times_us), demand, done] {
             std::vector<Wanted> wanted;
             for (const TimeUs time_us : times_us)
                 for (const Wanted& one : around(time_us, demand))
                     wanted.push_back(one);
             done(keyframes(wanted, asked_foam_));
             return true;
         },
         done});
}

void Simulation::fetch_current(Demand demand, Fetched done) {
    ask({[this, demand, done] {
             const TimeUs now_us = now_();
             std::vector<Wanted> wanted;
             for (std::size_t c = 0; c < sea_->budget.cascades.size(); ++c) {
                 if (!((demand.cascades >> c) & 1u))
                     continue;
                 const TimeUs interval_us = sea_->budget.cascades[c].interval_us;
                 // As far as the stream has come, or will start from.
                 const TimeUs end_us = streaming_[c]
                                           ? next_keyframe_us_[c]
                                           : interval_start(now_us + lead_us(c), interval_us);
                 for (TimeUs t = interval_start(now_us, interval_us); t < end_us; t += interval_us)
                     wanted.push_back({static_cast<int>(c), t, demand.fields});
             }
             done(keyframes(wanted, asked_foam_));
             return true;
         },
         done});
}

} // namespace seaway::server
