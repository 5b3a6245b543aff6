// SPDX-License-Identifier: Apache-2.0
// When a client says which keyframes it has, and that no stream stands still for it.
#include <deque>
#include <random>

#include <gtest/gtest.h>

#include "client/held/acknowledgements.h"
#include "server/publish/outbox.h"

namespace seaway::client {
namespace {

namespace limits = protocol::limits;

std::vector<std::uint64_t> numbers_of(const protocol::Bytes& bytes) {
    protocol::MessageReader reader(protocol::Sender::client);
    const auto message = reader.read(bytes);
    EXPECT_TRUE(message && protocol::check(**message));
    const wire::Ack& ack = *(*message)->body_as_Ack();
    std::vector<std::uint64_t> numbers{ack.keyframe()};
    if (ack.also() != nullptr)
        numbers.insert(numbers.end(), ack.also()->begin(), ack.also()->end());
    return numbers;
}

/// Keyframes that each of the first Acks names, for keyframes 1, 2, 3 and so on.
std::vector<std::size_t> sizes(Acknowledgements& acknowledgements, int keyframes) {
    std::vector<std::size_t> sizes;
    std::uint64_t next = 1;
    for (int number = 1; number <= keyframes; ++number)
        if (const auto ack = acknowledgements.complete(static_cast<std::uint64_t>(number))) {
            const std::vector<std::uint64_t> numbers = numbers_of(*ack);
            for (const std::uint64_t one : numbers)
                EXPECT_EQ(one, next++) << "all of them, in the order in which they came";
            sizes.push_back(numbers.size());
        }
    return sizes;
}

TEST(Acknowledgements, are_said_when_half_of_the_credit_is_complete_and_with_the_default_at_once) {
    using Sizes = std::vector<std::size_t>;
    for (const auto& [credit, together] :
         {std::pair(1, 1u), {2, 1u}, {3, 1u}, {4, 2u}, {5, 2u}, {6, 3u}, {7, 3u}, {8, 4u}}) {
        Acknowledgements acknowledgements;
        acknowledgements.begin(limits::keyframes_per_ack_max);
        EXPECT_FALSE(acknowledgements.granted(credit)) << "there is nothing to say";
        EXPECT_EQ(sizes(acknowledgements, 12), Sizes(12 / together, together)) << credit;
        EXPECT_EQ(acknowledgements.held_back(), 12 % together) << credit;
    }
    static_assert(limits::credit_default == 2);
}

// An older server takes the first number of an Ack and overlooks the others: their places would be lost for ever.
TEST(Acknowledgements, name_no_more_keyframes_than_the_server_says_that_it_takes) {
    using Sizes = std::vector<std::size_t>;
    for (const auto& [takes, together] :
         {std::pair(0u, 1u), {1u, 1u}, {2u, 2u}, {3u, 3u}, {4u, 4u}, {1000u, 4u}}) {
        Acknowledgements acknowledgements;
        acknowledgements.begin(takes);
        (void)acknowledgements.granted(8);
        EXPECT_EQ(sizes(acknowledgements, 12), Sizes(12 / together, together)) << takes;
    }
    Acknowledgements of_nobody_greeted;
    (void)of_nobody_greeted.granted(8);
    EXPECT_EQ(sizes(of_nobody_greeted, 3), Sizes(3, 1));
}

// Three of eight in a window that has one place now: nothing would be sent any more that could bring them out.
TEST(Acknowledgements, that_were_held_back_are_said_with_every_grant) {
    for (const int credit : {8, 1}) {
        Acknowledgements acknowledgements;
        acknowledgements.begin(limits::keyframes_per_ack_max);
        (void)acknowledgements.granted(8);
        for (const std::uint64_t number : {5, 6, 7})
            EXPECT_FALSE(acknowledgements.complete(number));
        const auto ack = acknowledgements.granted(credit);
        ASSERT_TRUE(ack);
        EXPECT_EQ(numbers_of(*ack), (std::vector<std::uint64_t>{5, 6, 7}));
        EXPECT_EQ(acknowledgements.held_back(), 0u);
        EXPECT_FALSE(acknowledgements.granted(credit)) << "once";
        EXPECT_EQ(acknowledgements.complete(8).has_value(), credit == 1);
    }
}

/// A server's outbox and a client, and what is on its way between them, by lot.
class Stream {
  public:
    explicit Stream(std::uint64_t seed) : lot_(seed) {
        client_.begin(limits::keyframes_per_ack_max);
        subscribe();
    }

    void step() {
        switch (lot_() % 12) {
        case 0:
            if (lot_() % 4 == 0)
                subscribe();
            break;
        case 1:
            fetch();
            break;
        case 2:
        case 3:
        case 4:
            publish();
            break;
        case 5:
            acknowledged();
            break;
        default:
            lot_() % 2 == 0 ? send() : arrive();
        }
    }
    /// What is sent arrives, and what is acknowledged is taken off; nothing is published.
    void end() {
        while (send() || arrive() || acknowledged())
            continue;
    }

    std::size_t waiting() const { return outbox_.bytes_waiting(); }
    std::size_t held_back() const { return client_.held_back(); }
    std::size_t acks = 0;
    std::size_t keyframes = 0;
    int credit = 0;

  private:
    server::EncodedKeyframePtr encoded(std::uint64_t number) {
        auto made = std::make_shared<server::EncodedKeyframe>();
        made->number = number;
        made->cascade = static_cast<int>(number % 3);
        made->epoch = static_cast<std::uint32_t>(number / 20);
        made->fields = height_;
        made->maps.push_back({.field = sea::Field::height, .error = 0, .parts = {}});
        for (std::uint64_t tile = 0; tile <= number % 3; ++tile)
            made->maps[0].parts.push_back(std::make_shared<const protocol::Bytes>(8));
        ends_[made->maps[0].parts.back()] = number;
        return made;
    }
    void publish() { outbox_.push_keyframe(encoded(++newest_), height_); }
    /// Of keyframes that are streamed, too, or were.
    void fetch() {
        const server::EncodedKeyframePtr some[] = {
            encoded(newest_ < 3 ? newest_ + 1 : newest_ - lot_() % 3), encoded(newest_ + 1)};
        EXPECT_TRUE(
            outbox_.push_fetched(some, height_, std::make_shared<const protocol::Bytes>(8)));
    }
    void subscribe() {
        credit = limits::credit_min + static_cast<int>(lot_() % limits::credit_max);
        outbox_.stop_stream();
        outbox_.set_credit(credit);
        auto granted = std::make_shared<const protocol::Bytes>(8);
        grants_[granted] = credit;
        outbox_.push_reply(std::move(granted));
    }
    bool send() {
        const protocol::SharedBytes message = outbox_.next();
        if (message != nullptr)
            line_.push_back(message);
        outbox_.sent();
        return message != nullptr;
    }
    bool arrive() {
        if (line_.empty())
            return false;
        const protocol::SharedBytes message = line_.front();
        line_.pop_front();
        std::optional<protocol::Bytes> ack;
        if (const auto grant = grants_.find(message); grant != grants_.end()) {
            ack = client_.granted(grant->second);
        } else if (const auto end = ends_.find(message); end != ends_.end()) {
            ack = client_.complete(end->second);
            ++keyframes;
        }
        if (ack)
            back_.push_back(*ack);
        return true;
    }
    bool acknowledged() {
        if (back_.empty())
            return false;
        for (const std::uint64_t number : numbers_of(back_.front()))
            (void)outbox_.acknowledge(number);
        back_.pop_front();
        ++acks;
        return true;
    }

    std::mt19937_64 lot_;
    const sea::FieldSet height_{sea::Field::height};
    server::Outbox outbox_;
    Acknowledgements client_;
    std::uint64_t newest_ = 0;
    std::deque<protocol::SharedBytes> line_;
    std::deque<protocol::Bytes> back_;
    std::map<protocol::SharedBytes, std::uint64_t> ends_; ///< last tiles, of which keyframe
    std::map<protocol::SharedBytes, int> grants_;
};

// Naive: a client that waits for half of its credit waits for keyframes that the server may not send.
TEST(Acknowledgements,
     held_back_never_keep_a_stream_waiting_whatever_becomes_of_credit_and_subscription) {
    std::size_t acks = 0, keyframes = 0;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        Stream stream(seed);
        for (int i = 0; i < 400; ++i)
            stream.step();
        stream.end();
        ASSERT_EQ(stream.waiting(), 0u) << "seed " << seed << ", credit " << stream.credit;
        ASSERT_LT(stream.held_back(), static_cast<std::size_t>(stream.credit)) << "seed " << seed;
        acks += stream.acks;
        keyframes += stream.keyframes;
    }
    EXPECT_LT(acks, keyframes * 3 / 4) << "that is what it is for";
}

} // namespace
} // namespace seaway::client
