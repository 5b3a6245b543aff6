// SPDX-License-Identifier: Apache-2.0
// Waves over real loopback sockets: what a session that wants them is sent, and what it is not.
#include "tests/server/net/net_fixture.h"

#include "protocol/limits.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;

class NetSpectrum : public NetTest {
  protected:
    void offer(std::uint32_t epoch, std::uint32_t chunks, std::size_t chunk_bytes = 100) {
        host.offer_spectra({SmallSea::spectrum_of(epoch, chunks, chunk_bytes)});
    }
    /// Reads a whole spectrum; its epoch, 0 and a failure if it is none.
    static std::uint32_t spectrum_from(Client& client) {
        const wire::Message* message = client.receive(Body::Spectrum);
        if (!message)
            return 0;
        const std::uint32_t epoch = message->body_as_Spectrum()->epoch();
        const std::uint32_t chunks = message->body_as_Spectrum()->chunks();
        for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
            message = client.receive();
            EXPECT_TRUE(message && message->body_as_SpectrumChunk());
            if (!message || !message->body_as_SpectrumChunk())
                return 0;
            EXPECT_EQ(message->body_as_SpectrumChunk()->chunk(), chunk);
            EXPECT_EQ(message->body_as_SpectrumChunk()->epoch(), epoch);
        }
        return epoch;
    }
};

TEST_F(NetSpectrum, a_wish_is_answered_by_what_is_granted_then_the_waves_in_order_then_nothing) {
    offer(1, 20);
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(9, {.error_m = 0.02f})));
    const wire::Message* message = client->receive(Body::SpectrumSubscribed);
    ASSERT_TRUE(message);
    const protocol::SpectrumGrant grant = protocol::grant(*message->body_as_SpectrumSubscribed());
    EXPECT_EQ(message->body_as_SpectrumSubscribed()->request_id(), 9u);
    EXPECT_EQ(grant.error_m, 0.01f);
    EXPECT_EQ(grant.slope_error, 0.005f);
    EXPECT_EQ(grant.why, "less");
    EXPECT_EQ(grant.spectra, 1u);
    EXPECT_EQ(spectrum_from(*client), 1u);
    EXPECT_TRUE(client->stays_quiet_for(std::chrono::milliseconds(300)));
}

TEST_F(NetSpectrum, the_waves_of_a_sea_that_is_announced_come_by_themselves_and_once) {
    offer(1, 3);
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
    EXPECT_EQ(spectrum_from(*client), 1u);
    host.offer_spectra({SmallSea::spectrum_of(1, 3), SmallSea::spectrum_of(2, 5)});
    net->announce(SmallSea::state_message(2));
    EXPECT_TRUE(client->receive(Body::SeaState));
    EXPECT_EQ(spectrum_from(*client), 2u) << "that of the sea that runs is held";
    net->announce(SmallSea::state_message(2));
    EXPECT_TRUE(client->receive(Body::SeaState));
    EXPECT_TRUE(client->stays_quiet_for(std::chrono::milliseconds(300)));
}

// A glide's spectrum is that of the sea which it leads to: who has it is sent nothing where that begins, a newcomer is.
TEST_F(NetSpectrum, the_sea_at_the_end_of_a_glide_is_sent_to_those_alone_who_do_not_have_it) {
    auto after = std::make_shared<server::EncodedSpectrum>(*SmallSea::spectrum_of(3, 4));
    after->ends_epoch = 2;
    host.offer_spectra({SmallSea::spectrum_of(1, 3), SmallSea::spectrum_of(2, 4), after});
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
    const wire::Message* message = client->receive(Body::SpectrumSubscribed);
    ASSERT_TRUE(message);
    EXPECT_EQ(message->body_as_SpectrumSubscribed()->spectra(), 2u) << "as many as come";
    EXPECT_EQ(spectrum_from(*client), 1u);
    EXPECT_EQ(spectrum_from(*client), 2u);
    host.offer_spectra({after});
    net->announce(SmallSea::state_message(3));
    EXPECT_TRUE(client->receive(Body::SeaState));
    EXPECT_TRUE(client->stays_quiet_for(std::chrono::milliseconds(300)));
    const auto newcomer = greeted();
    ASSERT_FALSE(newcomer->send(protocol::subscribe_spectrum(1, {})));
    EXPECT_EQ(spectrum_from(*newcomer), 3u);
}

// Naive: what tells of the second sea lets the waves of the first go, before the client knows how many to wait for.
TEST_F(NetSpectrum, the_grant_goes_before_all_waves_also_where_seas_are_told_of_with_them) {
    host.offer_spectra({SmallSea::spectrum_of(1, 3), SmallSea::spectrum_of(2, 3)});
    host.told_later = {{2, SmallSea::state_message(2)}};
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
    for (;;) {
        const wire::Message* message = client->receive();
        ASSERT_TRUE(message);
        ASSERT_NE(message->body_type(), Body::Spectrum);
        if (message->body_type() == Body::SpectrumSubscribed)
            break;
    }
    EXPECT_EQ(spectrum_from(*client), 1u);
    EXPECT_EQ(spectrum_from(*client), 2u);
}

TEST_F(NetSpectrum, who_does_not_ask_or_asks_no_more_is_sent_none) {
    offer(1, 3);
    start();
    const auto client = greeted(), bystander = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
    EXPECT_EQ(spectrum_from(*client), 1u);
    ASSERT_FALSE(client->send(protocol::unsubscribe(true)));
    ASSERT_FALSE(client->send(protocol::ping(5, 6))); // has been read by then
    ASSERT_TRUE(client->receive(Body::Pong));
    offer(2, 3);
    net->announce(SmallSea::state_message(2));
    for (Client* one : {client.get(), bystander.get()}) {
        EXPECT_TRUE(one->receive(Body::SeaState));
        EXPECT_TRUE(one->stays_quiet_for(std::chrono::milliseconds(300)));
    }
}

TEST_F(NetSpectrum, what_cannot_be_had_is_refused_by_name_and_the_session_goes_on) {
    start();
    const auto client = greeted();
    const auto code_of = [&](const protocol::SpectrumWish& wish) {
        EXPECT_FALSE(client->send(protocol::subscribe_spectrum(3, wish)));
        const wire::Message* message = client->receive(Body::Refused);
        return message ? message->body_as_Refused()->code() : ErrorCode::none;
    };
    EXPECT_EQ(code_of({}), ErrorCode::not_offered);
    EXPECT_EQ(code_of({.error_m = -1}), ErrorCode::bad_value);
    EXPECT_EQ(code_of({.error_m = std::nanf("")}), ErrorCode::bad_value);
    EXPECT_EQ(code_of({.slope_error = 11}), ErrorCode::bad_value);
    EXPECT_EQ(host.spectra_asked, 1) << "what is out of range is not looked for";
}

// The kernel takes some hundred KB of them; who reads nothing of the rest waits for ever and is never closed,
// and who asks again meanwhile is refused. Naive: a durable lane that is full closes the session.
TEST_F(NetSpectrum, a_slow_reader_is_not_closed_and_asks_in_vain_for_more_at_once) {
    offer(1, 4000, 16 * 1024);
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
    ASSERT_TRUE(client->receive(Body::Spectrum));
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(2, {})));
    const wire::Message* message = client->receive(Body::Refused);
    ASSERT_TRUE(message);
    EXPECT_EQ(message->body_as_Refused()->code(), ErrorCode::too_many_requests);
    EXPECT_EQ(message->body_as_Refused()->request_id(), 2u);
    ASSERT_FALSE(client->send(protocol::ping(5, 6))); // a reply goes before what waits
    EXPECT_TRUE(client->receive(Body::Pong));
}

TEST_F(NetSpectrum, is_made_once_for_each_who_asks_and_shared) {
    offer(1, 2);
    start();
    const long before = host.spectra.front()->messages.front().use_count();
    const auto a = greeted(), b = greeted();
    for (const auto& client : {a.get(), b.get()}) {
        ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
        EXPECT_EQ(spectrum_from(*client), 1u);
    }
    EXPECT_EQ(host.spectra_asked, 2);
    net->stop();
    EXPECT_EQ(host.spectra.front()->messages.front().use_count(), before) << "nobody copied them";
}

// Naive: what is announced is asked for once, and where there was no room for it its reader never has the waves.
TEST_F(NetSpectrum, waves_of_a_later_sea_for_which_there_is_no_room_come_once_there_is_some) {
    offer(1, 3);
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
    EXPECT_EQ(spectrum_from(*client), 1u);
    host.offer_spectra({SmallSea::spectrum_of(1, 3), SmallSea::spectrum_of(2, 5)});
    host.no_room_for_spectra = true;
    const auto begun = std::chrono::steady_clock::now();
    net->announce(SmallSea::state_message(2));
    EXPECT_TRUE(client->receive(Body::SeaState));
    ASSERT_TRUE(eventually([&] { return host.spectra_asked >= 2; }));
    host.no_room_for_spectra = false;
    EXPECT_EQ(spectrum_from(*client), 2u) << "whether it says something or not";
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - begun;
    const int asked = host.spectra_asked;
    EXPECT_LE(asked, 3 + since.count()) << "each try after a second";
    ASSERT_FALSE(client->send(protocol::ping(5, 6)));
    ASSERT_TRUE(client->receive(Body::Pong));
    EXPECT_EQ(host.spectra_asked, asked) << "and none once it has them";
}

// Naive: they go behind whatever else is sent, and who has nothing to ask is sent nothing else.
TEST_F(NetSpectrum, the_waves_of_a_sea_to_come_come_by_and_by_to_who_says_nothing) {
    offer(1, 3);
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
    EXPECT_EQ(spectrum_from(*client), 1u);
    const auto later =
        std::make_shared<server::EncodedSpectrum>(*SmallSea::spectrum_of(2, 12, 1000));
    later->whole_by_us = host.sea_time_us() + 10'000'000;
    host.offer_spectra({SmallSea::spectrum_of(1, 3), later});
    net->announce(SmallSea::state_message(2));
    EXPECT_TRUE(client->receive(Body::SeaState));
    ASSERT_TRUE(client->receive(Body::Spectrum));
    std::atomic<bool> whole = false;
    std::thread sea([&] { // which goes on, twenty times as fast as clocks
        while (!whole) {
            host.newest += 1'000'000 / interval_us;
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
    });
    for (int chunk = 0; chunk < 12; ++chunk)
        EXPECT_TRUE(client->receive(Body::SpectrumChunk)) << chunk;
    whole = true;
    sea.join();
}

TEST_F(NetSpectrum,
       a_wish_without_room_is_refused_with_the_time_to_ask_again_and_so_is_one_without_memory) {
    offer(1, 3);
    start();
    const auto client = greeted();
    for (std::atomic<bool>* const lacks :
         {&host.no_room_for_spectra, &host.no_memory_for_spectra}) {
        *lacks = true;
        ASSERT_FALSE(client->send(protocol::subscribe_spectrum(1, {})));
        expect_refused(*client, 1, ErrorCode::too_many_requests, "");
        *lacks = false;
    }
    ASSERT_FALSE(client->send(protocol::subscribe_spectrum(2, {})));
    EXPECT_EQ(spectrum_from(*client), 1u) << "who was refused may ask again";
}

// Naive: one line for all, in which who wants what is there waits for everything that others have made.
TEST_F(NetSpectrum, what_is_held_does_not_wait_for_what_is_made_for_others) {
    offer(1, 3);
    start();
    const auto maker = greeted(), neighbour = greeted();
    host.spectra_take_long = true;
    ASSERT_FALSE(maker->send(protocol::subscribe_spectrum(1, {})));
    ASSERT_TRUE(eventually([&] { return host.spectra_asked == 1; }));
    host.spectra_held = true;
    ASSERT_FALSE(neighbour->send(protocol::subscribe_spectrum(1, {})));
    EXPECT_EQ(spectrum_from(*neighbour), 1u);
    host.spectra_take_long = false;
    EXPECT_EQ(spectrum_from(*maker), 1u);
    EXPECT_EQ(host.spectra_asked, 1) << "the thread that makes them was asked for the first alone";
}

} // namespace
} // namespace seaway::tests
