// SPDX-License-Identifier: Apache-2.0
// Whose turn it is for a map, and who stands in line.
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "server/net/map_places.h"
#include "tests/support/allocations.h"

namespace seaway::tests {
namespace {

using server::Address;
using server::AddressPtr;
using server::MapPlaces;
using server::MapReader;
using server::NetOptions;

/// Nobody leaves the line.
const MapPlaces::Waits waits = [] { return true; };

/// Places, and what they hand to the io thread, which the test is.
class Places : public ::testing::Test {
  protected:
    std::deque<std::function<void()>> posted;
    const AddressPtr one = address("one"), two = address("two"), three = address("three");

    static AddressPtr address(const char* name) {
        return std::make_shared<Address>(name, NetOptions{});
    }
    MapPlaces made(int most) {
        return MapPlaces(most,
                         [this](std::function<void()> work) { posted.push_back(std::move(work)); });
    }
    void settle() {
        for (; !posted.empty(); posted.pop_front())
            posted.front()();
    }
};

// Naive: whichever place comes back counts as the one that was ending, and who could have waited for that is refused.
TEST_F(Places, one_that_is_ending_is_waited_for_whatever_others_did_meanwhile) {
    MapPlaces places = made(2);
    std::vector<MapPlaces::Place> held;
    const auto ask = [&] {
        return places.ask(
            one, [&](MapPlaces::Place place) { held.push_back(std::move(place)); }, waits);
    };
    ASSERT_TRUE(ask());
    MapPlaces::Place ending = std::move(held.back());
    held.clear();
    places.ends(ending);
    ASSERT_TRUE(ask());
    held.clear(); // refused, it never was a map
    settle();
    ASSERT_TRUE(ask()) << "the other place";
    ASSERT_TRUE(ask()) << "that of the one that ends";
    EXPECT_EQ(held.size(), 1u);
    EXPECT_FALSE(ask()) << "and no third";
    ending.reset();
    settle();
    EXPECT_EQ(held.size(), 2u);
    held.clear();
    settle();
    places.stop();
}

// Naive: who gave up still stands in line, and his address with him.
TEST_F(Places, who_leaves_the_line_leaves_nothing_there) {
    MapPlaces places = made(1);
    MapPlaces::Place held, mine;
    ASSERT_TRUE(places.ask(
        one, [&](MapPlaces::Place place) { held = std::move(place); }, waits));
    bool patient = true;
    const auto ask = [&] {
        return places.ask(
            two, [&](MapPlaces::Place place) { mine = std::move(place); },
            [&patient] { return patient; });
    };
    ASSERT_TRUE(ask());
    EXPECT_FALSE(ask()) << "waits already";
    patient = false;
    EXPECT_TRUE(places.ask(
        two, [&](MapPlaces::Place place) { mine = std::move(place); }, waits))
        << "as one that has none";
    held = nullptr;
    settle();
    EXPECT_NE(mine, nullptr);
    mine = nullptr;
    settle();
    places.stop();
}

// Naive: who gives way is looked for when somebody asks, and never again while he waits.
TEST_F(Places, a_reader_who_falls_behind_while_somebody_waits_gives_way_then) {
    struct Reader final : MapReader {
        double behind_s = 0;
        bool gave_way = false;
        MapPlaces::Place place;
        MapPlaces* places = nullptr;
        std::chrono::duration<double> behind() const override {
            return std::chrono::duration<double>(behind_s);
        }
        void give_way() override {
            gave_way = true;
            places->ends(place);
            place = nullptr;
        }
    };
    MapPlaces places = made(1);
    const auto slow = std::make_shared<Reader>();
    slow->places = &places;
    ASSERT_TRUE(places.ask(
        one, [&](MapPlaces::Place place) { slow->place = std::move(place); }, waits));
    places.reads(slow);
    MapPlaces::Place mine;
    ASSERT_TRUE(places.ask(
        two, [&](MapPlaces::Place place) { mine = std::move(place); }, waits));
    places.look_again();
    EXPECT_FALSE(slow->gave_way);
    slow->behind_s = 0.1;
    places.look_again();
    EXPECT_TRUE(slow->gave_way);
    places.look_again(); // and nobody more than is waited for
    settle();
    EXPECT_NE(mine, nullptr);
    mine = nullptr;
    settle();
    places.stop();
    EXPECT_FALSE(places.ask(
        two, [](const MapPlaces::Place&) {}, waits))
        << "it stops";
}

// Naive: a place comes back by a message, and where there is no memory for one it is lost, or the process.
TEST_F(Places, come_back_where_there_is_no_memory_to_say_so) {
    bool memory = true;
    MapPlaces places(1, [&](std::function<void()> work) {
        if (!memory)
            throw std::bad_alloc();
        posted.push_back(std::move(work));
    });
    MapPlaces::Place held, mine;
    ASSERT_TRUE(places.ask(
        one, [&](MapPlaces::Place place) { held = std::move(place); }, waits));
    ASSERT_TRUE(places.ask(
        two, [&](MapPlaces::Place place) { mine = std::move(place); }, waits));
    memory = false;
    held = nullptr;
    EXPECT_EQ(mine, nullptr);
    memory = true;
    places.look_again();
    EXPECT_NE(mine, nullptr) << "who waits asks each second";
    mine = nullptr;
    settle();
    EXPECT_TRUE(places.ask(
        one, [&](MapPlaces::Place place) { held = std::move(place); }, waits));
    places.stop();
    held = nullptr;
    settle();
}

// Naive: all that have come back are taken at once, and go with the one whose successor has no memory to begin.
TEST_F(Places, come_back_each_whatever_becomes_of_who_is_next) {
    bool memory = true;
    MapPlaces places(2, [&](std::function<void()> work) {
        if (!memory)
            throw std::bad_alloc();
        posted.push_back(std::move(work));
    });
    std::vector<MapPlaces::Place> held;
    const auto hold = [&](MapPlaces::Place place) { held.push_back(std::move(place)); };
    ASSERT_TRUE(places.ask(one, hold, waits));
    ASSERT_TRUE(places.ask(one, hold, waits));
    ASSERT_TRUE(places.ask(
        two, [](const MapPlaces::Place&) { throw std::bad_alloc(); }, waits));
    memory = false;
    held.clear();
    memory = true;
    EXPECT_THROW(places.look_again(), std::bad_alloc);
    settle();
    ASSERT_TRUE(places.ask(three, hold, waits));
    ASSERT_TRUE(places.ask(three, hold, waits));
    EXPECT_EQ(held.size(), 2u);
    places.stop();
    held.clear();
    settle();
}

// Naive: who is first in line is taken out of it before there is a place, and where there is no memory for that it stands nowhere.
TEST_F(Places, come_to_who_waits_also_where_there_was_no_memory_for_that_at_first) {
    int failed = 0;
    for (std::size_t after = 0; after < 6; ++after) {
        MapPlaces places = made(1);
        MapPlaces::Place held, mine;
        const auto hold = [&](MapPlaces::Place place) { held = std::move(place); };
        ASSERT_TRUE(places.ask(one, hold, waits));
        ASSERT_TRUE(places.ask(
            two, [&](MapPlaces::Place place) { mine = std::move(place); }, waits));
        held = nullptr;
        try {
            const NoMemoryOnce none(after);
            settle();
        } catch (const std::bad_alloc&) {
            ++failed;
            EXPECT_EQ(mine, nullptr) << after;
        }
        settle();
        places.look_again(); // as who waits does each second
        EXPECT_NE(mine, nullptr) << after;
        mine = nullptr;
        settle();
        ASSERT_TRUE(places.ask(three, hold, waits));
        EXPECT_TRUE(places.ask(
            two, [](const MapPlaces::Place&) {}, waits))
            << "as one that has none";
        places.stop();
        held = nullptr;
        settle();
    }
    EXPECT_GT(failed, 1);
}

// Naive: whoever asks at the right instant has the next place, which is who asks without pause.
TEST_F(Places, an_address_that_has_none_is_next_whoever_asks_without_pause) {
    MapPlaces places = made(2);
    std::deque<MapPlaces::Place> greedy, other;
    const auto ask = [&](const AddressPtr& who, std::deque<MapPlaces::Place>& held) {
        return places.ask(
            who, [&](MapPlaces::Place place) { held.push_back(std::move(place)); }, waits);
    };
    ASSERT_TRUE(ask(one, greedy) && ask(one, greedy));
    EXPECT_FALSE(ask(one, greedy));
    EXPECT_TRUE(ask(two, other)) << "waits";
    EXPECT_FALSE(ask(two, other)) << "once";
    EXPECT_TRUE(ask(three, other));
    EXPECT_TRUE(other.empty());
    greedy.pop_front();
    settle();
    EXPECT_EQ(other.size(), 1u);
    EXPECT_FALSE(ask(one, greedy));
    other.clear(); // two has had its map: three is next, before one
    settle();
    EXPECT_EQ(other.size(), 1u);
    other.clear();
    settle();
    EXPECT_TRUE(ask(one, greedy)) << "nobody waits";
    greedy.clear();
    settle();
    EXPECT_TRUE(ask(two, other) && ask(two, other)) << "nothing is remembered";
    other.clear();
    settle();
    places.stop();
}

} // namespace
} // namespace seaway::tests
