// SPDX-License-Identifier: Apache-2.0
// The line of keyframes that wait to be encoded: its bounds, who goes first, and who is left out.
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "base/elapsed.h"
#include "server/net/encode_worker.h"
#include "tests/support/eventually.h"

namespace seaway::tests {
namespace {

TEST(EncodeWorker, both_lines_are_bounded_and_streamed_keyframes_go_first) {
    server::EncodeWorker worker;
    std::promise<void> gate;
    std::promise<void> entered;
    ASSERT_TRUE(worker.submit_fetched([&](server::Encoder&) {
        entered.set_value();
        gate.get_future().wait();
        return true;
    }));
    entered.get_future().wait(); // nothing is taken from now on
    std::mutex mutex;
    std::string order;
    const auto note = [&](char kind) {
        return [&, kind](server::Encoder&) {
            const std::scoped_lock lock(mutex);
            order += kind;
            return true;
        };
    };
    using server::EncodeWorker;
    for (std::size_t i = 0; i < EncodeWorker::fetches_waiting_max; ++i)
        EXPECT_TRUE(worker.submit_fetched(note('f')));
    EXPECT_FALSE(worker.submit_fetched(note('F')));
    for (std::size_t i = 0; i < EncodeWorker::streamed_waiting_max; ++i)
        EXPECT_EQ(worker.submit_streamed(note(i == 0 ? 'o' : 's')), 0u);
    EXPECT_EQ(worker.submit_streamed(note('n')), 1u) << "the oldest is left out";
    gate.set_value();
    EXPECT_TRUE(eventually([&] {
        const std::scoped_lock lock(mutex);
        return order.size() ==
               EncodeWorker::fetches_waiting_max + EncodeWorker::streamed_waiting_max;
    }));
    const std::string streamed = std::string(EncodeWorker::streamed_waiting_max - 1, 's') + 'n';
    constexpr auto ahead = static_cast<std::size_t>(server::stream_slices_ahead);
    std::string turns;
    for (std::size_t i = 0; i < streamed.size(); ++i)
        turns += streamed[i] + std::string((i + 1) % ahead == 0 ? 1 : 0, 'f');
    turns.resize(EncodeWorker::fetches_waiting_max + EncodeWorker::streamed_waiting_max, 'f');
    EXPECT_EQ(order, turns);
    std::promise<void> again;
    EXPECT_TRUE(worker.submit_fetched([&](server::Encoder&) {
        again.set_value();
        return true;
    }));
    again.get_future().wait();
    worker.stop();
    EXPECT_EQ(worker.submit_streamed(note('S')), 1u);
}

/// A worker whose thread waits in a job until it is let go.
struct HeldUp {
    explicit HeldUp(const server::MemoryPtr& memory) : worker(memory) {
        std::promise<void> entered;
        EXPECT_TRUE(worker.submit_fetched([this, &entered](server::Encoder&) {
            entered.set_value();
            gate.get_future().wait();
            return true;
        }));
        entered.get_future().wait();
    }
    /// A job that writes this down.
    server::EncodeWorker::Job note(const std::string& what) {
        return [this, what](server::Encoder&) {
            order += what; // of the encode thread, read when it has done
            return true;
        };
    }
    /// What was written down, of streamed keyframes.
    std::string let_go() {
        std::promise<void> done;
        const server::KeyframeTiles last{
            .keyframe = nullptr, .codec_error = {}, .rank = server::quality_rungs};
        EXPECT_EQ(worker.submit_streamed(
                      [&](server::Encoder&) {
                          done.set_value();
                          return true;
                      },
                      last),
                  0u);
        gate.set_value();
        done.get_future().wait();
        return order;
    }

    std::promise<void> gate;
    std::string order;
    server::EncodeWorker worker;
};

server::KeyframeTiles at_rank(const sea::KeyframePtr& keyframe, std::size_t rank) {
    return {.keyframe = keyframe, .quality = static_cast<server::Quality>(rank), .rank = rank};
}

sea::KeyframePtr keyframe_of(std::size_t bytes) {
    auto made = std::make_shared<sea::Keyframe>();
    made->values.resize(bytes / sizeof(float));
    return made;
}

// Naive: each rung of a keyframe takes room for all of it, in the order of their numbers. Five sessions that read nothing, each with a
// wish of its own, then leave none for the rung that all others have.
TEST(EncodeWorker, a_keyframe_has_its_room_once_and_rungs_with_more_readers_go_first) {
    const auto memory = std::make_shared<server::Memory>();
    const std::size_t share = memory->share(server::MemoryUse::encoding);
    HeldUp held(memory);
    const sea::KeyframePtr first = keyframe_of(share / 2), second = keyframe_of(share / 3);
    for (const std::size_t rank : {3, 1, 2, 0})
        EXPECT_EQ(held.worker.submit_streamed(held.note("a" + std::to_string(rank)),
                                              at_rank(first, rank)),
                  0u);
    for (const std::size_t rank : {0, 1})
        EXPECT_EQ(held.worker.submit_streamed(held.note("b" + std::to_string(rank)),
                                              at_rank(second, rank)),
                  0u);
    EXPECT_EQ(memory->room(server::MemoryUse::encoding)->held_bytes(),
              first->bytes() + second->bytes());
    EXPECT_EQ(held.let_go(), "a0b0a1b1a2a3");
    EXPECT_TRUE(
        eventually([&] { return memory->room(server::MemoryUse::encoding)->held_bytes() == 0; }));
}

// Naive: what comes is refused, whatever it is, and those who have fallen behind get what is over.
TEST(EncodeWorker, where_there_is_no_room_all_that_waits_of_the_oldest_keyframe_is_left_out) {
    const auto memory = std::make_shared<server::Memory>();
    HeldUp held(memory);
    const auto next = [&](const std::string& name, std::size_t left_out) {
        const sea::KeyframePtr keyframe =
            keyframe_of(memory->share(server::MemoryUse::encoding) * 2 / 5);
        EXPECT_EQ(held.worker.submit_streamed(held.note(name + "0"), at_rank(keyframe, 0)),
                  left_out)
            << name;
        EXPECT_EQ(held.worker.submit_streamed(held.note(name + "1"), at_rank(keyframe, 1)), 0u)
            << name;
    };
    next("a", 0);
    next("b", 0);
    next("c", 2);
    next("d", 2);
    EXPECT_EQ(held.let_go(), "c0d0c1d1");
}

// Naive: a rung that has more readers than a moment ago overtakes itself, and who waits is sent the older keyframe last.
TEST(EncodeWorker, keyframes_of_one_rung_are_encoded_in_their_order_whatever_their_ranks) {
    HeldUp held(std::make_shared<server::Memory>());
    const sea::KeyframePtr first = keyframe_of(1000), second = keyframe_of(1000);
    const auto submit = [&](const std::string& name, const sea::KeyframePtr& keyframe,
                            server::Quality quality, std::size_t rank) {
        EXPECT_EQ(held.worker.submit_streamed(
                      held.note(name), {.keyframe = keyframe, .quality = quality, .rank = rank}),
                  0u);
    };
    submit("a0", first, 0, 0);
    submit("a1", first, 1, 1);
    submit("b1", second, 1, 0);
    submit("b0", second, 0, 1);
    EXPECT_EQ(held.let_go(), "a0a1b1b0");
}

// Naive: it stays behind what waits of it, which is last for as long as there is more than can be encoded.
TEST(EncodeWorker, a_rung_whose_turn_has_come_takes_what_waits_of_it_along) {
    HeldUp held(std::make_shared<server::Memory>());
    const sea::KeyframePtr first = keyframe_of(1000), second = keyframe_of(1000);
    for (const auto& [name, keyframe, quality, rank] : {std::tuple("a0", first, 0, 0),
                                                        {"a1", first, 1, 1},
                                                        {"b0", second, 0, 1},
                                                        {"b1", second, 1, 0}})
        EXPECT_EQ(held.worker.submit_streamed(held.note(name),
                                              {.keyframe = keyframe,
                                               .quality = static_cast<server::Quality>(quality),
                                               .rank = static_cast<std::size_t>(rank)}),
                  0u);
    EXPECT_EQ(held.let_go(), "a0a1b1b0");
}

TEST(EncodeWorker, a_large_fetch_lets_streamed_keyframes_and_starts_in_between) {
    server::EncodeWorker worker;
    std::promise<void> done;
    std::string order; // of the encode thread, read when it has done
    int slices = 0;
    ASSERT_TRUE(worker.submit_fetched([&](server::Encoder&) {
        order += 'f';
        if (++slices == 1)
            for (int i = 0; i < 2; ++i) {
                EXPECT_TRUE(worker.submit_start([&](server::Encoder&) {
                    order += 'b';
                    return true;
                }));
                EXPECT_EQ(worker.submit_streamed([&](server::Encoder&) {
                    order += 's';
                    return true;
                }),
                          0u);
            }
        if (slices == 4)
            done.set_value();
        return slices == 4;
    }));
    done.get_future().wait();
    EXPECT_EQ(order.substr(0, 3), "fss") << "streamed ones at once";
    EXPECT_TRUE(order == "fssbfbff" || order == "fssfbfbf") << order << ": the others in turn";
}

// Naive: streamed keyframes go first, whatever waits. Once they take all of the thread nobody can join, and no fetch ends.
TEST(EncodeWorker, an_encoder_that_is_never_idle_ends_starts_and_fetches_all_the_same) {
    HeldUp held(std::make_shared<server::Memory>());
    int streamed = 0; // all of the encode thread, read when it has stopped
    const std::function<bool(server::Encoder&)> stream = [&](server::Encoder&) {
        held.order += 's';
        if (++streamed < 1000) // the line is never empty
            (void)held.worker.submit_streamed(stream);
        return true;
    };
    std::promise<void> done;
    int others = 0;
    const auto other = [&](char kind, int slices_left) {
        return [&, kind, slices_left](server::Encoder&) mutable {
            held.order += kind;
            if (++others == 4)
                done.set_value();
            return --slices_left == 0;
        };
    };
    EXPECT_EQ(held.worker.submit_streamed(stream), 0u);
    EXPECT_TRUE(held.worker.submit_fetched(other('f', 2)));
    for (int i = 0; i < 2; ++i)
        EXPECT_TRUE(held.worker.submit_start(other('b', 1)));
    held.gate.set_value();
    done.get_future().wait();
    held.worker.stop();
    EXPECT_EQ(held.order.substr(0, 20), "ssssbssssfssssbssssf");
}

// Naive: turns go by count, and a fetch of a large grid has most of the thread: between two of its slices four of the stream's.
TEST(EncodeWorker, slices_of_a_fetch_that_are_long_wait_for_as_much_of_the_stream) {
    HeldUp held(std::make_shared<server::Memory>());
    std::promise<void> done;
    int slices = 0;
    EXPECT_TRUE(held.worker.submit_fetched([&](server::Encoder&) {
        const double end_s =
            thread_cpu_seconds() + 0.05; // of 100 short ones of the stream each takes microseconds
        while (thread_cpu_seconds() < end_s) {
        }
        held.order += 'f';
        if (++slices == 2)
            done.set_value();
        return slices == 2;
    }));
    for (int i = 0; i < 100; ++i)
        EXPECT_EQ(held.worker.submit_streamed([&](server::Encoder&) {
            held.order += 's';
            return true;
        }),
                  0u);
    held.gate.set_value();
    done.get_future().wait();
    held.worker.stop();
    EXPECT_EQ(held.order, "ssssf" + std::string(96, 's') + "f");
}

} // namespace
} // namespace seaway::tests
