// SPDX-License-Identifier: Apache-2.0
// Bytes as what a crowd does to a simulation: questions about times and places of every kind, with
// and without foam, subscriptions that come and go, askers that leave, a clock that leaps. Each
// question is answered once: by one answer a point, or by why not; nothing stops the thread. Input:
// 25 bytes an act: its kind, then time_us, x_m, y_m as they lie in memory.
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <future>
#include <list>

#include "server/device/native_synthesizer.h"
#include "server/simulation/simulation.h"

using namespace seaway;

namespace {

constexpr const char* scene_text = R"(
[[sea.system]]
type = "swell"
significant_height_m = 1.0
peak_period_s = 4.0
from_deg = 250
[[cascade]]
length_m = 101.0
size = 64
[foam]
threshold = 0.9
decay_s = 0.7
)";

const sea::FieldSet with_foam = sea::surface_fields | sea::FieldSet{sea::Field::foam};

struct Bench {
    std::atomic<sea::TimeUs> now_us = 0;
    server::Subscriptions subscriptions;
    std::unique_ptr<server::Simulation> simulation;

    Bench() {
        const Result<sea::Scene> scene = sea::parse_scene(scene_text, "fuzz", ".");
        simulation = *server::Simulation::start(
            *server::SeaCourse::begin(*scene),
            [](const sea::RealizationPtr& sea, std::uint32_t epoch,
               server::Making) -> Result<std::unique_ptr<server::Synthesizer>> {
                auto made = std::make_unique<server::NativeSynthesizer>(1);
                SEAWAY_TRY(made->set_sea(sea, epoch));
                return std::unique_ptr<server::Synthesizer>(std::move(made));
            },
            subscriptions, [this] { return now_us.load(); }, {});
        subscriptions.on_change([this] { simulation->demand_changed(); });
    }
};

void require(bool condition) {
    if (!condition)
        std::abort();
}

/// A question that waits for its answer. A second answer throws, and ends the run.
template <class T>
struct Asked {
    std::promise<Result<T>> promise;
    auto done() {
        return [this](Result<T> result) { promise.set_value(std::move(result)); };
    }
};

/// The parts of a fetch, put together.
server::Simulation::Fetched whole(std::function<void(Result<std::vector<sea::KeyframePtr>>)> done) {
    const auto all = std::make_shared<std::vector<sea::KeyframePtr>>();
    return [done = std::move(done), all](Result<server::FetchedKeyframes> part) {
        if (!part)
            return done(part.error());
        all->insert(all->end(), part->keyframes.begin(), part->keyframes.end());
        if (part->last)
            done(std::move(*all));
    };
}

/// Questions that are under way, and what each must come to.
struct Crowd {
    std::list<Asked<std::vector<sea::Answer>>> answers;
    std::list<Asked<std::vector<sea::KeyframePtr>>> fetches;
    std::list<std::function<void()>> expectations;
    std::shared_ptr<const void> here = std::make_shared<char>();
    std::vector<std::shared_ptr<const void>> askers;
    bool left = false;

    template <class T, class Right>
    void expect(Asked<T>& asked, bool in_range, bool may_leave, const Right& right) {
        expectations.push_back([this, &asked, in_range, may_leave, right] {
            const Result<T> result = asked.promise.get_future().get();
            if (result)
                return require(in_range && right(*result));
            const bool gone = may_leave && left && result.error().is(server::Refusal::gone);
            require(gone || (!in_range && result.error().is(server::Refusal::bad_value)));
        });
    }
};

void act(Bench& bench, Crowd& crowd, unsigned kind, const sea::QueryPoint& point) {
    server::Simulation& simulation = *bench.simulation;
    const bool time_fits = sea::in_time_range(point.time_us);
    const bool may_leave = kind >= 128;
    // Each question is another's: one asker alone may not have as many waiting.
    const server::Asker one(crowd.askers.emplace_back(std::make_shared<char>()));
    const server::Asker asker = may_leave ? one.about(crowd.here) : one;
    switch (kind % 8) {
    case 0:
    case 1: {
        auto& asked = crowd.answers.emplace_back();
        simulation.answer({point}, kind % 8 == 1, asked.done(), asker);
        return crowd.expect(asked, server::check_point(point).has_value(), may_leave,
                            [](const auto& answers) { return answers.size() == 1; });
    }
    case 2:
    case 3: {
        auto& asked = crowd.fetches.emplace_back();
        const sea::FieldSet fields = kind % 8 == 2 ? sea::surface_fields : with_foam;
        simulation.fetch({point.time_us}, {1u, fields}, whole(asked.done()), asker);
        return crowd.expect(asked, time_fits, may_leave, [fields, point](const auto& held) {
            return held.size() == 2 && held[0]->time_us <= point.time_us &&
                   point.time_us < held[1]->time_us && held[0]->fields.contains(fields) &&
                   held[1]->fields.contains(fields);
        });
    }
    case 4: {
        auto& asked = crowd.fetches.emplace_back();
        simulation.fetch_current({1u, with_foam}, whole(asked.done()), asker);
        return crowd.expect(asked, true, may_leave, [](const auto&) { return true; });
    }
    case 5:
        return bench.subscriptions.set(kind / 8 % 4,
                                       {1u, kind / 32 % 2 ? with_foam : sea::surface_fields});
    case 6:
        return bench.subscriptions.erase(kind / 8 % 4);
    case 7: // a day at most: the clock is the server's own
        bench.now_us +=
            static_cast<sea::TimeUs>(static_cast<std::uint64_t>(point.time_us) % 86'400'000'000);
        return simulation.demand_changed();
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static Bench& bench = *new Bench;
    constexpr std::size_t act_bytes = 25;
    Crowd crowd;
    for (; size >= act_bytes; data += act_bytes, size -= act_bytes) {
        sea::QueryPoint point{};
        std::memcpy(&point.time_us, data + 1, 8);
        std::memcpy(&point.x_m, data + 9, 8);
        std::memcpy(&point.y_m, data + 17, 8);
        act(bench, crowd, data[0], point);
    }
    crowd.left = true;
    crowd.here = nullptr;
    for (const std::function<void()>& expectation : crowd.expectations)
        expectation();
    for (server::SessionId session = 0; session < 4; ++session)
        bench.subscriptions.erase(session);
    return 0;
}
