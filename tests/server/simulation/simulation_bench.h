// SPDX-License-Identifier: Apache-2.0
// A simulation of a small sea with the native synthesizer, whose device fails and whose clock turns
// as the test wishes.
#pragma once

#include <atomic>
#include <future>
#include <mutex>
#include <new>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/device/native_synthesizer.h"
#include "server/device/rebuilt_synthesizer.h"
#include "server/simulation/simulation.h"

namespace seaway::server {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

inline constexpr TimeUs second_us = 1'000'000;

inline constexpr const char* small_sea = R"(
[sea]
seed = 7
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 9.0
from_deg = 250
fetch_m = 40e3
spreading = "hasselmann"
[[cascade]]
length_m = 301.0
size = 64
[[cascade]]
length_m = 43.0
size = 64
[accuracy]
height_error_m = 0.02
)";

/// Puts the parts of a fetch together: `done` is called once, with all keyframes or an error.
inline Simulation::Fetched whole(std::function<void(Result<std::vector<sea::KeyframePtr>>)> done) {
    return [done = std::move(done), all = std::make_shared<std::vector<sea::KeyframePtr>>()](
               Result<FetchedKeyframes> part) {
        if (!part)
            return done(part.error());
        all->insert(all->end(), part->keyframes.begin(), part->keyframes.end());
        if (part->last)
            done(std::move(*all));
    };
}

/// Who asks, where it does not matter.
inline const Asker someone = Asker::who_stays();

/// The small sea, with more tables in its text.
inline sea::Scene small_scene(const std::string& more = {}) {
    const Result<sea::Scene> scene = sea::parse_scene(small_sea + more, "small_sea", ".");
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    return scene.value();
}

inline RunningSeaPtr running_sea(const std::string& more = {}) {
    return *make_running_sea(small_scene(more), 1);
}

/// Fails the next `failures` calls, as a lost device does.
class FailingSynthesizer final : public Synthesizer {
  public:
    FailingSynthesizer(std::shared_ptr<std::atomic<int>> failures, std::atomic<int>& no_memory,
                       std::atomic<int>& trims)
        : failures_(std::move(failures)), no_memory_(no_memory), trims_(trims) {}
    std::string description() const override { return inner_.description(); }
    Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) override {
        return inner_.set_sea(std::move(sea), epoch);
    }
    Result<FoamMapPtr> open_foam(int size, const FoamMap* from) override {
        return inner_.open_foam(size, from);
    }
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override {
        if (failures_->fetch_sub(1) > 0)
            return Error{"VK_ERROR_DEVICE_LOST"};
        if (no_memory_.fetch_sub(1) > 0)
            return Error{DeviceError::out_of_memory, "native synthesis: out of memory"};
        return inner_.synthesize(requests);
    }
    SynthesisCounters counters() const override { return inner_.counters(); }
    void trim() override {
        ++trims_;
        inner_.trim();
    }

  private:
    std::shared_ptr<std::atomic<int>> failures_;
    std::atomic<int>&no_memory_, &trims_;
    NativeSynthesizer inner_{1};
};

/// What makes keyframes of this course's seas, with one thread.
inline std::unique_ptr<RebuiltSynthesizer> native_synthesizer(const SeaCourse& course) {
    return RebuiltSynthesizer::start(
               [](const sea::RealizationPtr& sea, std::uint32_t epoch,
                  Making) -> Result<std::unique_ptr<Synthesizer>> {
                   auto made = std::make_unique<NativeSynthesizer>(1);
                   SEAWAY_TRY(made->set_sea(sea, epoch));
                   return std::unique_ptr<Synthesizer>(std::move(made));
               },
               course.first()->realization, 1, nullptr)
        .value();
}

/// A simulation, what it published, and its clock.
struct Bench {
    const int answer_threads;
    RunningSeaPtr sea; ///< that the course begins with
    std::shared_ptr<SeaCourse> course = std::make_shared<SeaCourse>(sea);
    std::atomic<TimeUs> now_us = 0;
    std::atomic<TimeUs> leap_us = 0; ///< of the clock at each look
    std::shared_ptr<std::atomic<int>> failures = std::make_shared<std::atomic<int>>(0);
    std::mutex mutex;
    std::vector<sea::KeyframePtr> published;
    std::vector<sea::KeyframePtr> published_rarer; ///< for those who take fewer
    std::atomic<int> no_memory = 0;                ///< of the next calls
    std::atomic<int> trims = 0;                    ///< of the device
    std::atomic<int> warnings = 0;
    std::atomic<int> uploads = 0;    ///< of the sea to a device
    std::atomic<int> speechless = 0; ///< no memory for the next words of its end
    std::promise<std::string> failed;
    Subscriptions subscriptions;
    std::unique_ptr<Simulation> simulation;

    /// Lets nothing go for want of use, where nothing else is said, however long a busy machine stands still.
    explicit Bench(const std::string& more = {}, WorkBudget budget = {}, int threads = 2,
                   std::chrono::milliseconds trims_every = std::chrono::hours(1))
        : answer_threads(threads), sea(running_sea(more)) {
        const auto memory =
            std::make_shared<Memory>(Memory::bytes_default, MemoryNeeds{}, trims_every);
        Result<std::unique_ptr<Simulation>> started = Simulation::start(
            course,
            [this](const sea::RealizationPtr& realization, std::uint32_t epoch,
                   server::Making) -> Result<std::unique_ptr<Synthesizer>> {
                auto made = std::make_unique<FailingSynthesizer>(failures, no_memory, trims);
                SEAWAY_TRY(made->set_sea(realization, epoch));
                ++uploads;
                return std::unique_ptr<Synthesizer>(std::move(made));
            },
            subscriptions, [this] { return now_us += leap_us; },
            {[this](const sea::KeyframePtr& keyframe, std::size_t rate) {
                 const std::scoped_lock lock(mutex);
                 (rate == 0 ? published : published_rarer).push_back(keyframe);
             },
             [this](const std::string&) { ++warnings; },
             [this](const std::string& why) {
                 if (speechless-- > 0)
                     throw std::bad_alloc();
                 failed.set_value(why);
             }},
            budget, memory, answer_threads);
        simulation = std::move(started).value();
        subscriptions.on_change([this] { simulation->demand_changed(); });
    }

    std::vector<sea::Answer> answer(std::vector<sea::QueryPoint> points, bool exact = false) {
        Result<std::vector<sea::Answer>> answers = try_answer(std::move(points), exact);
        EXPECT_TRUE(answers) << (answers ? "" : answers.error().message);
        return answers ? *std::move(answers) : std::vector<sea::Answer>();
    }

    Result<std::vector<sea::Answer>> try_answer(std::vector<sea::QueryPoint> points,
                                                bool exact = false) {
        return wait<std::vector<sea::Answer>>(
            [&](const auto& done) { simulation->answer(std::move(points), exact, done, someone); });
    }

    std::vector<sea::KeyframePtr> fetch_current(Demand demand) {
        return *wait<std::vector<sea::KeyframePtr>>(
            [&](const auto& done) { simulation->fetch_current(demand, whole(done), someone); });
    }

    Result<std::vector<sea::KeyframePtr>> fetch(std::vector<TimeUs> times_us, Demand demand) {
        return wait<std::vector<sea::KeyframePtr>>([&](const auto& done) {
            simulation->fetch(std::move(times_us), demand, whole(done), someone);
        });
    }

    Result<SurfacePtr> surface(TimeUs time_us) {
        return wait<SurfacePtr>(
            [&](const auto& done) { simulation->surface(time_us, done, someone); });
    }

    /// Lets the thread look at the clock and waits until what is due has been published: a slice of
    /// the stream comes before each answer, until there is none to do.
    void settle() {
        std::uint64_t before = 0;
        do {
            before = simulation->counters().stream_slices;
            fetch_current({0, {}});
        } while (simulation->counters().stream_slices != before);
    }

    void advance(TimeUs us) {
        now_us += us;
        simulation->demand_changed(); // wakes the thread
        settle();
    }

    std::vector<TimeUs> times(int cascade) {
        const std::scoped_lock lock(mutex);
        std::vector<TimeUs> all;
        for (const sea::KeyframePtr& keyframe : published)
            if (keyframe->cascade == cascade)
                all.push_back(keyframe->time_us);
        return all;
    }

  private:
    /// Asks, and waits for what comes back.
    template <class T, class Ask>
    static Result<T> wait(const Ask& ask) {
        std::promise<Result<T>> promise;
        ask([&](Result<T> result) { promise.set_value(std::move(result)); });
        return promise.get_future().get();
    }
};

/// Holds the simulation thread from now until it goes, and those that answer.
class Gate {
  public:
    explicit Gate(Bench& bench) {
        std::vector<std::promise<void>> entered(static_cast<std::size_t>(1 + bench.answer_threads));
        const auto hold = [&entered, opened = opened_](int thread) {
            return [&held = entered[static_cast<std::size_t>(thread)], opened](const auto&) {
                held.set_value();
                opened.wait();
            };
        };
        bench.simulation->fetch({}, {}, hold(0), someone);
        for (int i = 1; i <= bench.answer_threads; ++i)
            bench.simulation->answer({}, false, hold(i), someone);
        for (std::promise<void>& one : entered)
            one.get_future().wait();
    }
    ~Gate() { open_.set_value(); }
    Gate(const Gate&) = delete;
    Gate& operator=(const Gate&) = delete;

  private:
    std::promise<void> open_;
    const std::shared_future<void> opened_ = open_.get_future().share();
};

/// Three metres between them, and so much time.
inline std::vector<sea::QueryPoint> points_in_a_row(std::size_t count, TimeUs step_us = 0) {
    std::vector<sea::QueryPoint> points;
    for (std::size_t i = 0; i < count; ++i)
        points.push_back({3.0 * static_cast<double>(i), 1, static_cast<TimeUs>(i) * step_us});
    return points;
}

} // namespace seaway::server
