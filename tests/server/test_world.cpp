// SPDX-License-Identifier: Apache-2.0
// The world that sessions talk to, over a simulation.
#include <atomic>
#include <memory>

#include <gtest/gtest.h>

#include "server/host/refusal.h"
#include "server/world.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

// Naive: only the simulation knows who may go, and the world forgets to tell it. A fetch of foam walks
// through hundreds of ticks: on a slow machine that was a quarter of a minute of work for nobody.
TEST(World, what_who_has_gone_asked_for_is_dropped_without_work) {
    Bench bench;
    World world(bench.sea, {}, [] { return TimeUs{0}; });
    world.attach(*bench.simulation);
    auto here = std::make_shared<char>();
    const Asker asker(here);
    here = nullptr;
    std::atomic<int> gone = 0;
    const auto note = [&](const auto& result) {
        gone += !result && result.error().is(Refusal::gone);
    };
    const FieldSet with_foam = sea::surface_fields | FieldSet{Field::foam};
    world.fetch({{}, {~0u, with_foam}, asker}, note);  // the start of a subscription
    world.fetch({{0}, {~0u, with_foam}, asker}, note); // a fetch
    world.query({false, {{1.0, 2.0, 0}}, asker}, note);
    world.query({true, {{1.0, 2.0, 0}}, asker}, note);
    world.map(
        {{{"width_m", "10"}, {"height_m", "10"}, {"columns", "4"}, {"rows", "4"}}, asker, [] {}},
        note);
    for (int i = 0; i < 5; ++i)
        bench.settle(); // askers take turns: each time it is one of theirs
    EXPECT_EQ(gone, 5) << "each is answered all the same";
    EXPECT_EQ(bench.simulation->counters().synthesis.transforms, 0u);
}

} // namespace
} // namespace seaway::server
