// SPDX-License-Identifier: Apache-2.0
#include <pthread.h>

#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "client/link/failure.h"
#include "client/link/requests.h"
#include "tests/support/allocations.h"

namespace seaway::client {
namespace {

/// Requests whose messages are collected, and outcomes by order of starting.
class RequestsTest : public ::testing::Test {
  protected:
    std::vector<std::uint32_t> sent;
    bool send_works = true;
    std::vector<std::string> outcomes; ///< outlives the requests, which fail when they go
    Requests requests{[this](std::uint32_t request_id, const protocol::Bytes&) {
        sent.push_back(request_id);
        return send_works;
    }};

    void start(Lane lane, std::int64_t deadline_us = 1000) {
        const std::size_t index = outcomes.size();
        outcomes.emplace_back("open");
        requests.start(
            lane, [](std::uint32_t) { return protocol::Bytes(8); }, deadline_us,
            [this, index](const Result<Reply>& reply) {
                EXPECT_EQ(outcomes[index], "open") << "a handler is called once";
                outcomes[index] = reply ? "done" : reply.error().message;
            },
            {sea::Field::height});
    }
};

TEST_F(RequestsTest, hold_back_what_the_server_would_refuse_and_send_it_in_order) {
    for (int i = 0; i < 20; ++i)
        start(Lane::query);
    EXPECT_EQ(sent.size(), static_cast<std::size_t>(Requests::queries_in_flight_max));
    start(Lane::bulk);
    start(Lane::bulk);
    ASSERT_EQ(sent.size(), static_cast<std::size_t>(Requests::queries_in_flight_max) + 1);
    EXPECT_TRUE(requests.finish(Lane::query, sent[3], Reply()));
    EXPECT_EQ(outcomes[3], "done");
    EXPECT_EQ(sent.back(), 9u) << "the ninth query follows; the second fetch still waits";
    EXPECT_TRUE(requests.finish(Lane::bulk, sent[8], Reply()));
    EXPECT_EQ(sent.back(), 22u);
}

TEST_F(RequestsTest, match_replies_by_number_and_lane) {
    start(Lane::query);
    EXPECT_FALSE(requests.finish(Lane::bulk, sent[0], Reply()));
    EXPECT_FALSE(requests.finish(Lane::query, sent[0] + 1, Reply()));
    EXPECT_TRUE(requests.refuse(sent[0], failed(Failure::refused, "no")));
    EXPECT_EQ(outcomes[0], "no");
    EXPECT_FALSE(requests.refuse(sent[0], failed(Failure::refused, "no")));
}

TEST_F(RequestsTest, report_a_deadline_but_keep_the_place_until_the_server_is_done) {
    start(Lane::bulk, 100);
    start(Lane::bulk, 300);
    requests.expire(200);
    EXPECT_NE(outcomes[0].find("in time"), std::string::npos);
    EXPECT_EQ(outcomes[1], "open");
    EXPECT_EQ(sent.size(), 1u) << "the server still works on the first";
    EXPECT_TRUE(requests.finish(Lane::bulk, sent[0], Reply()));
    EXPECT_EQ(sent.size(), 2u);
}

TEST_F(RequestsTest, a_deadline_has_passed_at_its_very_time_and_not_before) {
    start(Lane::bulk, 100); // on its way
    start(Lane::bulk, 100); // waits
    requests.expire(99);
    EXPECT_EQ(outcomes, (std::vector<std::string>{"open", "open"}));
    requests.expire(100);
    for (const std::string& outcome : outcomes)
        EXPECT_NE(outcome.find("in time"), std::string::npos) << outcome;
}

TEST_F(RequestsTest, one_that_waits_beyond_its_deadline_is_never_sent) {
    start(Lane::bulk, 1000);
    start(Lane::bulk, 100);
    requests.expire(200);
    EXPECT_NE(outcomes[1].find("in time"), std::string::npos);
    EXPECT_TRUE(requests.finish(Lane::bulk, sent[0], Reply()));
    EXPECT_EQ(sent.size(), 1u);
}

TEST_F(RequestsTest, all_fail_when_the_connection_ends_and_later_ones_too) {
    for (int i = 0; i < 10; ++i)
        start(Lane::query);
    requests.fail_all(failed(Failure::lost, "gone"));
    start(Lane::query);
    for (const std::string& outcome : outcomes)
        EXPECT_EQ(outcome, "gone");
}

// Naive: the place of what the server has dropped without a word is taken for ever.
TEST_F(RequestsTest, of_a_lane_that_is_abandoned_fail_and_the_next_one_is_sent) {
    start(Lane::spectrum);
    start(Lane::spectrum);
    start(Lane::query);
    requests.expire(1000); // its place stays taken until the server is done
    start(Lane::spectrum, 5000);
    ASSERT_EQ(sent.size(), 2u);
    requests.abandon(Lane::spectrum, failed(Failure::refused, "nobody wants it"));
    EXPECT_EQ(outcomes[3], "nobody wants it");
    EXPECT_FALSE(requests.finish(Lane::spectrum, sent[0], Reply()))
        << "what comes late is nobody's";
    start(Lane::spectrum);
    ASSERT_EQ(sent.size(), 3u);
    EXPECT_TRUE(requests.finish(Lane::spectrum, sent[2], Reply()));
    EXPECT_EQ(outcomes[4], "done");
    EXPECT_TRUE(requests.finish(Lane::query, sent[1], Reply())) << "others go on";
}

// Naive: half of it has been moved when there is no memory for its place, and what is left of it is sent, and told, and stops
// all that comes after it.
TEST_F(RequestsTest, that_find_no_memory_are_whole_or_told_and_stop_no_other) {
    for (std::size_t after = 0; after < 12; ++after) {
        std::vector<std::uint32_t> sent_ids;
        sent_ids.reserve(2);
        Requests all([&](std::uint32_t request_id, const protocol::Bytes& message) {
            EXPECT_FALSE(message.empty());
            sent_ids.push_back(request_id);
            return true;
        });
        int told = 0;
        bool thrown = false;
        const auto ask = [&] {
            all.start(
                Lane::query, [](std::uint32_t) { return protocol::Bytes(100); }, 1000,
                [&told](const Result<Reply>&) { ++told; });
        };
        try {
            const tests::NoMemoryOnce now(after);
            ask();
        } catch (const std::bad_alloc&) {
            thrown = true;
        }
        ask();
        all.expire(2000);
        EXPECT_TRUE(told == 2 || (thrown && told == 1)) << told << " after " << after;
        all.fail_all(failed(Failure::lost, "gone"));
        EXPECT_LE(told, 2);
    }
}

TEST_F(RequestsTest, that_cannot_be_sent_for_want_of_memory_leave_their_place) {
    bool sends = false;
    Requests all([&](std::uint32_t, const protocol::Bytes&) {
        if (!sends)
            throw std::bad_alloc();
        return true;
    });
    int lost = 0;
    const auto ask = [&] {
        all.start(
            Lane::bulk, [](std::uint32_t) { return protocol::Bytes(1); }, 1000,
            [&lost](const Result<Reply>& reply) { lost += reply ? 0 : 1; });
    };
    EXPECT_THROW(ask(), std::bad_alloc);
    EXPECT_EQ(lost, 1);
    sends = true;
    ask();
    EXPECT_TRUE(all.finish(Lane::bulk, 2, Reply())) << "it was sent";
}

// Naive: one who runs out of memory when he is told takes those behind him along, and they wait for ever.
TEST_F(RequestsTest, are_all_told_also_behind_one_that_has_no_memory_for_it) {
    for (const bool late : {false, true}) {
        outcomes.clear();
        for (int i = 0; i < 3; ++i) {
            start(Lane::query);
            requests.start(
                Lane::query, [](std::uint32_t) { return protocol::Bytes(8); }, 1000,
                [](const Result<Reply>&) { throw std::bad_alloc(); });
        }
        if (late)
            requests.fail_all(failed(Failure::lost, "gone"));
        else
            requests.expire(1000);
        for (const std::string& outcome : outcomes)
            EXPECT_NE(outcome, "open") << late;
    }
}

TEST_F(RequestsTest, fail_when_they_are_given_up) {
    std::string outcome;
    {
        Requests short_lived([](std::uint32_t, const protocol::Bytes&) { return true; });
        short_lived.start(
            Lane::query, [](std::uint32_t) { return protocol::Bytes(8); }, 1000,
            [&](const Result<Reply>& reply) { outcome = reply.error().message; });
    }
    EXPECT_NE(outcome.find("closed"), std::string::npos);
}

TEST_F(RequestsTest, fail_at_once_when_nothing_can_be_sent) {
    send_works = false;
    start(Lane::query);
    EXPECT_NE(outcomes[0], "open");
}

/// Runs it on a thread whose stack is small.
void with_a_stack_of(std::size_t bytes, std::function<void()> work) {
    pthread_attr_t attributes;
    ASSERT_EQ(pthread_attr_init(&attributes), 0);
    ASSERT_EQ(pthread_attr_setstacksize(&attributes, bytes), 0);
    pthread_t thread{};
    const auto run = [](void* given) -> void* {
        (*static_cast<std::function<void()>*>(given))();
        return nullptr;
    };
    ASSERT_EQ(pthread_create(&thread, &attributes, run, &work), 0);
    ASSERT_EQ(pthread_join(thread, nullptr), 0);
    pthread_attr_destroy(&attributes);
}

// Naive: each that fails begins the next from within. The stack is then as deep as many wait: a megabyte
// and more, where a thread of a program may have less.
TEST_F(RequestsTest, all_that_wait_fail_on_a_small_stack_when_nothing_more_can_be_sent) {
    constexpr std::size_t many = Requests::waiting_max + Requests::queries_in_flight_max;
    for (std::size_t i = 0; i < many; ++i)
        start(Lane::query);
    send_works = false;
    with_a_stack_of(512 * 1024,
                    [&] { EXPECT_TRUE(requests.finish(Lane::query, sent[0], Reply())); });
    EXPECT_EQ(sent.size(), many) << "each is tried";
    EXPECT_EQ(std::count(outcomes.begin(), outcomes.end(), "open"),
              Requests::queries_in_flight_max - 1);
    EXPECT_EQ(std::count(outcomes.begin(), outcomes.end(), "done"), 1);
}

TEST_F(RequestsTest, are_bounded) {
    for (std::size_t i = 0; i < Requests::waiting_max + 8; ++i)
        start(Lane::query);
    EXPECT_EQ(outcomes.back(), "open");
    start(Lane::query);
    EXPECT_NE(outcomes.back().find("limit"), std::string::npos);
}

TEST_F(RequestsTest, a_granted_subscription_survives_the_refusal_of_its_first_keyframes) {
    start(Lane::bulk);
    Grant grant;
    grant.fields = sea::surface_fields;
    requests.note_grant(sent[0], grant);
    EXPECT_EQ(requests.bulk_fields(), std::vector<sea::FieldSet>{sea::surface_fields});
    EXPECT_TRUE(requests.refuse(sent[0], failed(Failure::refused, "busy")));
    EXPECT_EQ(outcomes[0], "done");
}

} // namespace
} // namespace seaway::client
