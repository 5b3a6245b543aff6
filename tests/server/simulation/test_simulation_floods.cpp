// SPDX-License-Identifier: Apache-2.0
// One simulation beside floods of every kind, and without what the system should give: what is streamed,
// what a single point waits for, and that nothing but the one question fails.
#include <algorithm>
#include <system_error>
#include <thread>

#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

/// Four sessions that ask all they may: points at far times, exact sums, far keyframes, maps.
class Flood {
  public:
    explicit Flood(Bench& bench) {
        for (int i = 0; i < 4; ++i) {
            const Asker asker(here_.emplace_back(std::make_shared<char>()));
            const TimeUs far_us = (i + 1) * 3'600'000'000;
            for (int k = 0; k < 4; ++k) {
                bench.simulation->answer(
                    points_in_a_row(512, far_us), false, [](const auto&) {}, asker);
                bench.simulation->answer(
                    points_in_a_row(256, far_us), true, [](const auto&) {}, asker);
                bench.simulation->surface(
                    far_us + k * 60'000'000, [](const auto&) {}, asker);
            }
            for (int k = 0; k < 2; ++k)
                bench.simulation->fetch(
                    {far_us, 2 * far_us, 3 * far_us}, {3u, sea::surface_fields},
                    [this](const auto& part) { fetched_ += !part || part->last; }, asker);
        }
    }
    void leave() { here_.clear(); }
    int fetched() const { return fetched_; }

  private:
    std::vector<std::shared_ptr<const void>> here_;
    std::atomic<int> fetched_ = 0;
};

TEST(Floods, of_every_kind_cost_a_subscriber_no_keyframe) {
    Bench bench;
    bench.subscriptions.set(1, {3u, sea::surface_fields});
    bench.settle();
    Flood flood(bench);
    const TimeUs interval_us = bench.sea->budget.cascades[0].interval_us;
    for (int i = 0; i < 20; ++i)
        bench.advance(interval_us);
    EXPECT_EQ(bench.simulation->counters().keyframes_skipped, 0u);
    for (const int cascade : {0, 1}) {
        const std::vector<TimeUs> times_us = bench.times(cascade);
        const TimeUs step_us =
            bench.sea->budget.cascades[static_cast<std::size_t>(cascade)].interval_us;
        for (std::size_t i = 1; i < times_us.size(); ++i)
            EXPECT_EQ(times_us[i] - times_us[i - 1], step_us) << cascade;
    }
    EXPECT_GE(bench.times(0).size(), 20u);
    flood.leave();
}

// Naive: one of each who came before. A single thread answers: with two, the other goes on with the flood while
// the system keeps the one from its core.
TEST(Floods, of_small_questions_are_not_answered_before_a_single_point_that_comes_later) {
    Bench bench({}, {}, 1);
    std::atomic<int> answered = 0;
    std::promise<int> before;
    const auto single = std::make_shared<char>();
    std::vector<std::shared_ptr<const void>> flood;
    {
        const Gate gate(bench);
        for (int i = 0; i < 4; ++i) {
            const Asker asker(flood.emplace_back(std::make_shared<char>()));
            for (int k = 0; k < 8; ++k)
                bench.simulation->answer(
                    points_in_a_row(8, 0), true, [&](const auto&) { ++answered; }, asker);
        }
        bench.simulation->answer(
            points_in_a_row(1, 0), true, [&](const auto&) { before.set_value(answered); },
            Asker(single));
    }
    EXPECT_EQ(before.get_future().get(), 0);
    bench.settle();
    while (answered < 32)
        std::this_thread::yield();
}

// The same on the thread that has the device.
TEST(Floods, of_every_kind_are_not_fetched_before_a_keyframe_that_is_asked_for_later) {
    Bench bench;
    std::promise<int> before;
    const auto single = std::make_shared<char>();
    std::optional<Flood> flood;
    {
        const Gate gate(bench);
        flood.emplace(bench);
        bench.simulation->fetch({0}, {1u, {Field::height}}, whole([&](const auto& all) {
                                    EXPECT_TRUE(all);
                                    before.set_value(flood->fetched());
                                }),
                                Asker(single));
    }
    EXPECT_EQ(before.get_future().get(), 0);
    flood->leave();
    bench.settle();
}

// A limit of processes or threads: std::thread throws. Naive: the server aborts.
TEST(Floods, a_thread_that_the_system_does_not_give_costs_one_map_and_no_more) {
    Bench bench;
    std::promise<Error> refused;
    bench.simulation->surface(
        0,
        [&](const Result<SurfacePtr>& surface) {
            if (surface)
                throw std::system_error(
                    std::make_error_code(std::errc::resource_unavailable_try_again));
            refused.set_value(surface.error());
        },
        someone);
    const Error why = refused.get_future().get();
    EXPECT_TRUE(why.is(Refusal::busy));
    EXPECT_GT(why.retry_after_ms, 0u);
    EXPECT_EQ(bench.answer({{1.0, 2.0, 0}}).size(), 1u) << "the simulation goes on";
    EXPECT_TRUE(bench.simulation->healthy());
}

// Naive: with the last keyframe that is held the thread goes to sleep, and what its device has to spare is never let go of.
TEST(Floods, what_a_stream_leaves_is_let_go_of_after_it_has_ended) {
    Bench bench({}, {}, 2, std::chrono::milliseconds(1));
    bench.subscriptions.set(1, {1u, {Field::height, Field::height_rate}});
    bench.settle(); // asks
    const int asked = bench.trims;
    const auto held = [&] { return bench.simulation->counters().store.keyframes; };
    int last = 0; // while some are held, however long this thread stands still
    EXPECT_TRUE(tests::eventually([&] { // nobody asks any more, the stream goes on
        last = bench.trims;
        bench.now_us += 20'000;
        bench.simulation->demand_changed();
        return last > asked + 2 * trims_after_work && held() > 0;
    }));
    bench.subscriptions.erase(1);
    EXPECT_TRUE(tests::eventually([&] { return bench.trims >= last + trims_after_work / 2; }))
        << "a handful lets go of these keyframes";
    EXPECT_EQ(held(), 0u);
}

// Naive: a spline that was let go between two looks, or maps that another thread has let go meanwhile, and who waits for them waits for
// ever, or is given those of fewer fields.
TEST(Floods, answers_and_maps_are_the_same_whatever_is_let_go_meanwhile) {
    Bench keeps;
    std::vector<double> heights_m;
    const auto point = [](int i) { return sea::QueryPoint{7.0 * i, 3.0, 50 + 90'000 * (i % 7)}; };
    for (int i = 0; i < 70; ++i)
        heights_m.push_back(keeps.answer({point(i)}).front().height_m);
    Bench forgets({}, {}, 2, std::chrono::milliseconds(1));
    forgets.subscriptions.set(1, {1u, {Field::height, Field::height_rate}});
    std::thread fetches([&] {
        for (int i = 0; i < 70; ++i) {
            const auto some = forgets.fetch({point(i).time_us}, {3u, sea::surface_fields});
            const auto all = keeps.fetch({point(i).time_us}, {3u, sea::surface_fields});
            ASSERT_TRUE(some && all);
            ASSERT_EQ(some->size(), all->size());
            for (std::size_t k = 0; k < all->size(); ++k)
                for (const Field field : sea::surface_fields)
                    EXPECT_TRUE(
                        std::ranges::equal((*some)[k]->plane(field), (*all)[k]->plane(field)));
        }
    });
    for (int round = 0; round < 5; ++round)
        for (int i = 0; i < 70; ++i) {
            forgets.now_us += 2'000;
            forgets.simulation->demand_changed();
            EXPECT_EQ(forgets.answer({point(i)}).front().height_m,
                      heights_m[static_cast<std::size_t>(i)])
                << round << ' ' << i;
        }
    fetches.join();
}

} // namespace
} // namespace seaway::server
