// SPDX-License-Identifier: Apache-2.0
// Bytes as questions to a simulation: times and places of every kind. Each is answered, one answer
// a point, or refused because it is out of range; nothing stops the thread. Input: 25 bytes a
// question: its kind, then time_us, x_m, y_m as they lie in memory.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <future>

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
)";

std::unique_ptr<server::Simulation> make_simulation() {
    static const server::Subscriptions nobody;
    const Result<sea::Scene> scene = sea::parse_scene(scene_text, "fuzz", ".");
    return *server::Simulation::start(
        *server::make_running_sea(*scene, 1),
        [](const sea::RealizationPtr& sea,
           std::uint32_t epoch) -> Result<std::unique_ptr<server::Synthesizer>> {
            auto made = std::make_unique<server::NativeSynthesizer>(1);
            SEAWAY_TRY(made->set_sea(sea, epoch));
            return std::unique_ptr<server::Synthesizer>(std::move(made));
        },
        nobody, [] { return sea::TimeUs{0}; }, {});
}

/// Asks, waits, and holds what comes back against what was asked.
template <class T, class Ask, class Right>
void hold(bool in_range, const Ask& ask, const Right& right) {
    std::promise<Result<T>> promise;
    ask([&](Result<T> result) { promise.set_value(std::move(result)); });
    const Result<T> result = promise.get_future().get();
    if (result.has_value() != in_range || (result && !right(*result)))
        std::abort();
    if (!result && !result.error().is(server::Refusal::bad_value))
        std::abort();
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static server::Simulation& simulation = *make_simulation().release();
    constexpr std::size_t question_bytes = 25;
    for (; size >= question_bytes; data += question_bytes, size -= question_bytes) {
        sea::QueryPoint point{};
        std::memcpy(&point.time_us, data + 1, 8);
        std::memcpy(&point.x_m, data + 9, 8);
        std::memcpy(&point.y_m, data + 17, 8);
        const bool time_fits = sea::in_time_range(point.time_us);
        if (data[0] % 4 == 3) {
            hold<std::vector<sea::KeyframePtr>>(
                time_fits,
                [&](auto done) {
                    simulation.fetch({point.time_us}, {1u, sea::surface_fields}, std::move(done));
                },
                [&](const auto& held) {
                    return held.size() == 2 && held[0]->time_us <= point.time_us &&
                           point.time_us < held[1]->time_us;
                });
            continue;
        }
        hold<std::vector<sea::Answer>>(
            server::check_point(point).has_value(),
            [&](auto done) { simulation.answer({point}, data[0] % 4 == 2, std::move(done)); },
            [](const auto& answers) { return answers.size() == 1; });
    }
    return 0;
}
