// SPDX-License-Identifier: Apache-2.0
// Keyframes in two forms: what the encoder makes of them, and who is sent which.
#include <cmath>
#include <deque>

#include <gtest/gtest.h>
#include <unistd.h>

#include "client/held/tile_assembly.h"
#include "protocol/tile_codec.h"
#include "server/publish/encoder.h"
#include "server/publish/outbox.h"
#include "tests/server/publish/predicted_tiles.h"

namespace seaway::server {
namespace {

namespace limits = protocol::limits;
using protocol::SharedBytes;
using sea::Field;
using sea::FieldSet;

// Hard case F7: nothing adds up. Ten thousand frames of tiles alone: HardCase.F7_the_ten_thousandth_frame_*.
TEST(PredictedTiles, one_whole_keyframe_and_differences_are_all_whole_keyframes_to_the_bit) {
    constexpr int frames = 2000;
    Encoder encoder;
    client::TileAssembly follows, joins;
    for (int n = 0; n < frames; ++n) {
        const EncodedKeyframePtr made = encode(encoder, running_keyframe(n));
        ASSERT_EQ(made->base, n == 0 ? 0u : static_cast<std::uint64_t>(n));
        const auto whole = take(joins, messages_of(*made, false));
        const auto followed = take(follows, messages_of(*made, n > 0));
        ASSERT_TRUE(whole && followed) << n;
        ASSERT_TRUE(same_bits(*whole, *followed)) << n;
        const sea::Keyframe truth = running_keyframe(n);
        for (const Field field : both_fields)
            for (std::size_t i = 0; i < truth.plane_size(); ++i)
                ASSERT_LE(std::abs(static_cast<double>(whole->keyframe().plane(field)[i]) -
                                   static_cast<double>(truth.plane(field)[i])),
                          static_cast<double>(field == Field::height ? bounds[0] : bounds[1]));
        if (n == 0)
            continue;
        // Two messages; of their 800 samples little is left.
        EXPECT_LT(bytes_of(messages_of(*made, true)), bytes_of(messages_of(*made, false)) * 2 / 3);
    }
    EXPECT_EQ(encoder.counters().fields_predicted, 2u * (frames - 1));
}

TEST(PredictedTiles, what_came_before_is_of_the_same_sea_cascade_and_quality) {
    Encoder encoder;
    const EncodedKeyframePtr first = encode(encoder, running_keyframe(0));
    sea::Keyframe other_sea = running_keyframe(1);
    other_sea.epoch = 2;
    EXPECT_EQ(encode(encoder, other_sea)->base, 0u);
    EXPECT_EQ(encode(encoder, running_keyframe(1, 20, 1))->base, 0u) << "another cascade";
    EXPECT_EQ(encode(encoder, running_keyframe(1), predicted, quality + 1)->base, 0u);
    EXPECT_EQ(encode(encoder, running_keyframe(1))->base, first->number);
}

TEST(PredictedTiles, only_what_is_newer_takes_part) {
    Encoder encoder;
    encode(encoder, running_keyframe(4));
    const EncodedKeyframePtr fifth = encode(encoder, running_keyframe(5));
    const EncodedKeyframePtr earlier = encode(encoder, running_keyframe(2));
    EXPECT_EQ(earlier->base, 0u);
    EXPECT_EQ(tile_of(earlier->maps[0].parts[0]).base(), std::nullopt);
    EXPECT_EQ(encode(encoder, running_keyframe(6))->base, fifth->number);
    // Left out ones, as where an encoder is behind: from what there is.
    EXPECT_EQ(encode(encoder, running_keyframe(9))->base, 4u);
}

// Naive: what is newer stays the base of a stream whose sea has gone back to where a pause began, and until it has come there
// again every keyframe is whole.
TEST(PredictedTiles, of_a_stream_that_goes_back_the_second_keyframe_is_predicted_again) {
    Encoder encoder;
    const std::shared_ptr<Room> streamed = Room::of(100'000'000);
    const auto stream = [&](int interval) {
        const auto made = encoder.encode(running_keyframe(interval), std::span(bounds).first(2),
                                         quality, both_fields, predicted, streamed.get());
        EXPECT_TRUE(made);
        return *made;
    };
    for (const int interval : {1000, 1001})
        stream(interval);
    const EncodedKeyframePtr first = stream(1);
    EXPECT_EQ(first->base, 0u);
    const EncodedKeyframePtr second = stream(2);
    EXPECT_EQ(second->base, first->number);
    // Nor does a newcomer's start, which is older, take the base from those who are there.
    EXPECT_EQ(stream(0)->base, 0u);
    EXPECT_EQ(stream(3)->base, second->number);
}

TEST(PredictedTiles, nothing_is_predicted_without_a_law_or_both_maps_or_where_it_does_not_pay) {
    Encoder encoder;
    for (int n = 0; n < 3; ++n) {
        EXPECT_EQ(encode(encoder, running_keyframe(n), {}, 1)->base, 0u);
        EXPECT_EQ(encode(encoder, running_keyframe(n, 20, 0, {Field::height}), predicted, 2)->base,
                  0u);
        EXPECT_EQ(encode(encoder, running_keyframe(n, 22), predicted, 3)->base, 0u)
            << "no such grid";
        const float lossless[] = {0, 0};
        EXPECT_EQ((*encoder.encode(running_keyframe(n), lossless, 4, both_fields, predicted))->base,
                  0u);
    }
    EXPECT_EQ(encoder.counters().fields_predicted, 0u);
}

// Somebody comes who wants foam, too: what was encoded stays what it was, in both forms.
TEST(PredictedTiles, maps_that_are_added_later_leave_both_forms_as_they_are) {
    Encoder encoder;
    const FieldSet three = both_fields | FieldSet{Field::foam};
    const auto encode_some = [&](int n, FieldSet wanted) {
        return *encoder.encode(running_keyframe(n, 20, 0, three), bounds, quality, wanted,
                               predicted);
    };
    encode_some(0, both_fields);
    const EncodedKeyframePtr before = encode_some(1, both_fields);
    const EncodedKeyframePtr after = encode_some(1, three);
    ASSERT_EQ(after->maps.size(), 3u);
    EXPECT_EQ(after->base, before->base);
    EXPECT_EQ(after->maps[0].differences, before->maps[0].differences);
    EXPECT_TRUE(after->maps[2].differences.empty()) << "foam follows from no waves";
}

TEST(PredictedTiles, bases_of_seas_that_are_over_hold_no_memory) {
    const std::shared_ptr<Room> room = Room::of(100'000'000);
    const std::shared_ptr<Room> streamed = Room::of(100'000'000);
    Encoder encoder(room);
    const auto held_after = [&](std::uint32_t seas) {
        for (std::uint32_t epoch = 1; epoch <= seas; ++epoch) {
            sea::Keyframe keyframe = running_keyframe(static_cast<int>(epoch));
            keyframe.epoch = epoch;
            keyframe.time_us = 20'000'000 * static_cast<sea::TimeUs>(epoch);
            EXPECT_TRUE(encoder.encode(keyframe, std::span(bounds).first(2), quality, both_fields,
                                       predicted, streamed.get()));
        }
        return room->held_bytes();
    };
    const std::size_t bytes_of_a_base = 4 * 20 * 20 * sizeof(float);
    const std::size_t messages = held_after(1) - bytes_of_a_base;
    // The messages of all are remembered; of bases no more than four lie within a minute.
    EXPECT_LT(held_after(30), 31 * (messages + 200) + 5 * bytes_of_a_base);
}

TEST(PredictedTiles, without_room_the_next_one_is_whole) {
    Encoder encoder(Room::of(2000)); // less than a base of 20 x 20 twice
    for (int n = 0; n < 4; ++n)
        EXPECT_EQ(encode(encoder, running_keyframe(n))->base, 0u);
}

// ---- outbox --------------------------------------------------------------------------------

/// Hands out what can be, acknowledged at once.
std::vector<SharedBytes> drain(Outbox& outbox, int keyframes = 100) {
    std::vector<SharedBytes> sent;
    std::uint64_t last = 0;
    int begun = 0;
    while (const SharedBytes next = outbox.next()) {
        const std::uint64_t number = tile_of(next).keyframe();
        if (number != last && ++begun > keyframes)
            ADD_FAILURE() << "more than was to come";
        last = number;
        outbox.acknowledge(number);
        sent.push_back(next);
    }
    return sent;
}

// The other way round: a keyframe that was streamed without heights is encoded again, with them.
TEST(PredictedTiles,
     heights_that_are_added_later_come_in_both_forms_and_the_file_has_what_is_sent) {
    Encoder encoder;
    const FieldSet three = both_fields | FieldSet{Field::foam};
    const auto encode_some = [&](int n, FieldSet wanted) {
        return *encoder.encode(running_keyframe(n, 20, 0, three), bounds, quality, wanted,
                               predicted);
    };
    const EncodedKeyframePtr first = encode_some(0, three);
    encode_some(1, {Field::foam});
    const EncodedKeyframePtr made = encode_some(1, three);
    EXPECT_EQ(made->base, first->number);
    EXPECT_FALSE(made->maps[0].differences.empty());
    const auto room = Room::of(1'000'000);
    const KeyframeFilePtr file = keyframe_file(
        *made, [](std::size_t length, protocol::Bytes& out) { out.push_back(length & 0xff); },
        *room);
    ASSERT_TRUE(file);
    Outbox outbox;
    outbox.push_keyframe(first, three);
    drain(outbox);
    outbox.sent();
    outbox.push_keyframe(made, three, file);
    protocol::Bytes written;
    while (const SharedBytes next = outbox.next()) {
        written.push_back(next->size() & 0xff);
        written.insert(written.end(), next->begin(), next->end());
    }
    const Outbox::Run run = outbox.run();
    ASSERT_TRUE(run.of);
    protocol::Bytes in_file(run.end - run.begin);
    ASSERT_EQ(::pread(run.of->file->handle(), in_file.data(), in_file.size(),
                      static_cast<off_t>(run.begin)),
              static_cast<ssize_t>(in_file.size()));
    EXPECT_EQ(in_file, written);
}

bool holds_differences(const std::vector<SharedBytes>& messages) {
    for (const SharedBytes& bytes : messages) {
        const wire::Tile& tile = tile_of(bytes);
        if (protocol::is_difference({tile.payload()->data(), tile.payload()->size()}))
            return true;
    }
    return false;
}

TEST(Outbox, differences_go_to_who_was_streamed_what_they_are_to) {
    Encoder encoder;
    Outbox follows, joins;
    for (int n = 0; n < 5; ++n) {
        const EncodedKeyframePtr made = encode(encoder, running_keyframe(n));
        follows.push_keyframe(made, both_fields);
        EXPECT_EQ(holds_differences(drain(follows)), n > 0) << n;
        if (n < 3)
            continue;
        joins.push_keyframe(made, both_fields);
        EXPECT_EQ(holds_differences(drain(joins)), n > 3) << n;
    }
    EXPECT_EQ(follows.counters().keyframes_predicted, 4u);
    EXPECT_EQ(joins.counters().keyframes_predicted, 1u);
    joins.stop_stream(); // and begins again
    joins.push_keyframe(encode(encoder, running_keyframe(5)), both_fields);
    EXPECT_FALSE(holds_differences(drain(joins)));
}

TEST(Outbox, who_takes_no_rates_is_sent_whole_heights) {
    Encoder encoder;
    Outbox outbox;
    for (int n = 0; n < 3; ++n) {
        outbox.push_keyframe(encode(encoder, running_keyframe(n)), {Field::height});
        EXPECT_FALSE(holds_differences(drain(outbox)));
    }
    outbox.push_keyframe(encode(encoder, running_keyframe(3)), both_fields);
    EXPECT_FALSE(holds_differences(drain(outbox))) << "there are no rates that it follows from";
}

TEST(Outbox, a_fetched_keyframe_is_whole) {
    Encoder encoder;
    Outbox outbox;
    encode(encoder, running_keyframe(0));
    const EncodedKeyframePtr made = encode(encoder, running_keyframe(1));
    ASSERT_NE(made->base, 0u);
    ASSERT_TRUE(outbox.push_fetched(
        std::span(&made, 1), both_fields,
        std::make_shared<const protocol::Bytes>(protocol::fetch_done(1, 1, both_fields))));
    EXPECT_EQ(outbox.next(), made->maps[0].parts[0]);
}

// A reader that is behind is brought up by the steps that it has missed, for as long as they are fewer bytes than the
// newest keyframe alone; then by that.
TEST(Outbox, steps_that_wait_stay_while_they_are_less_than_the_newest_whole) {
    Encoder encoder;
    Outbox outbox;
    client::TileAssembly client;
    outbox.set_credit(1);
    outbox.push_keyframe(encode(encoder, running_keyframe(0)), both_fields);
    std::vector<SharedBytes> first;
    while (const SharedBytes next = outbox.next())
        first.push_back(next); // not acknowledged: what follows waits
    ASSERT_TRUE(take(client, first));
    std::size_t waiting = 0;
    int n = 1;
    EncodedKeyframePtr newest;
    for (;; ++n) {
        newest = encode(encoder, running_keyframe(n));
        const std::size_t with_it = waiting + message_bytes(*newest, both_fields, true);
        outbox.push_keyframe(newest, both_fields);
        ASSERT_EQ(outbox.counters().keyframes_replaced == 0,
                  with_it < message_bytes(*newest, both_fields))
            << n;
        if (outbox.counters().keyframes_replaced > 0)
            break;
        waiting = with_it;
        if (n == 2) { // read on: both steps come, and come to their keyframes
            outbox.acknowledge(1);
            std::vector<SharedBytes> messages;
            while (const SharedBytes next = outbox.next())
                messages.push_back(next);
            EXPECT_TRUE(holds_differences(messages));
            bool unpredicted = false;
            const client::HeldKeyframePtr reached = take(client, messages, &unpredicted);
            ASSERT_TRUE(reached);
            EXPECT_EQ(reached->keyframe().time_us, running_keyframe(n).time_us);
            EXPECT_FALSE(unpredicted);
            EXPECT_FALSE(outbox.acknowledge(2)) << "was on the way to the newest";
            EXPECT_TRUE(outbox.acknowledge(3));
            outbox.push_keyframe(encode(encoder, running_keyframe(++n)), both_fields);
            while (outbox.next())
                ;
            waiting = 0;
        }
    }
    EXPECT_EQ(outbox.counters().keyframes_replaced, static_cast<std::uint64_t>(n - 4));
    outbox.acknowledge(4);
    std::vector<SharedBytes> last;
    while (const SharedBytes next = outbox.next())
        last.push_back(next);
    EXPECT_EQ(last, messages_of(*newest, false)) << "the newest, whole, and nothing else";
}

// Its credit and the way there and back allow fewer keyframes than there are: it is sent what is new, as without predictions.
TEST(Outbox, who_acknowledges_late_is_no_further_behind_by_steps_than_by_whole_keyframes) {
    constexpr int late = 3; // intervals from when a keyframe is sent to its acknowledgement
    const auto worst_lag = [](FieldSet fields) {
        Encoder encoder;
        Outbox outbox;
        outbox.set_credit(1);
        std::deque<std::pair<int, std::uint64_t>> under_way; // when, of what
        int worst = 0;
        std::uint64_t newest = 0;
        for (int n = 0; n < 40; ++n) {
            outbox.push_keyframe(encode(encoder, running_keyframe(n)), fields);
            for (; !under_way.empty() && under_way.front().first <= n; under_way.pop_front())
                outbox.acknowledge(under_way.front().second);
            while (const SharedBytes next = outbox.next()) {
                const std::uint64_t number = tile_of(next).keyframe();
                if (number != newest)
                    under_way.emplace_back(n + late, number);
                newest = number;
            }
            worst = std::max(worst, n + 1 - static_cast<int>(newest));
        }
        return worst;
    };
    EXPECT_EQ(worst_lag({Field::height}), late - 1) << "whole ones";
    EXPECT_EQ(worst_lag(both_fields), late - 1);
}

// However small the steps are: each keeps a whole keyframe in memory.
TEST(Outbox, of_the_smallest_steps_sixteen_wait_and_then_the_newest_alone) {
    const auto bytes = [](std::size_t count) {
        return std::make_shared<const protocol::Bytes>(count);
    };
    Outbox outbox;
    outbox.set_credit(1);
    for (std::uint64_t n = 1; n <= limits::steps_waiting_max + 2; ++n) {
        auto made = std::make_shared<EncodedKeyframe>(EncodedKeyframe{n, 1});
        made->base = n - 1;
        for (const Field field : both_fields)
            made->maps.push_back({field, 0, {bytes(100'000)}, {bytes(10)}});
        outbox.push_keyframe(made, both_fields);
        while (n == 1 && outbox.next())
            ; // which is not acknowledged
        EXPECT_EQ(outbox.counters().keyframes_replaced,
                  n <= limits::steps_waiting_max + 1 ? 0u : limits::steps_waiting_max);
    }
}

} // namespace
} // namespace seaway::server
