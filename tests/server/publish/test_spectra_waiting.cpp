// SPDX-License-Identifier: Apache-2.0
// Outbox: spectra among what waits.
#include <gtest/gtest.h>

#include "protocol/limits.h"
#include "server/publish/outbox.h"

namespace seaway::server {
namespace {

EncodedSpectrumPtr spectrum_of(std::uint32_t epoch, int messages) {
    auto made = std::make_shared<EncodedSpectrum>();
    made->epoch = epoch;
    for (int n = 0; n < messages; ++n)
        made->messages.push_back(std::make_shared<const protocol::Bytes>(50));
    return made;
}

TEST(Outbox, chunks_of_a_spectrum_go_in_order_after_sea_states_and_before_tiles) {
    Outbox outbox;
    const EncodedSpectrumPtr first = spectrum_of(1, 2), second = spectrum_of(2, 1);
    const protocol::SharedBytes state = std::make_shared<const protocol::Bytes>(8),
                                reply = std::make_shared<const protocol::Bytes>(9);
    auto tiles = std::make_shared<EncodedKeyframe>();
    tiles->number = 1;
    tiles->fields = {sea::Field::height};
    tiles->maps.push_back({sea::Field::height, 0, {std::make_shared<const protocol::Bytes>(10)}});
    outbox.push_keyframe(tiles, {sea::Field::height});
    outbox.push_spectrum(first);
    outbox.push_spectrum(second);
    EXPECT_EQ(outbox.next(), first->messages[0]);
    ASSERT_TRUE(outbox.push_durable(state));
    outbox.push_reply(reply);
    EXPECT_EQ(outbox.next(), reply);
    EXPECT_EQ(outbox.next(), state);
    EXPECT_TRUE(outbox.spectrum_waiting());
    EXPECT_EQ(outbox.next(), first->messages[1]);
    EXPECT_EQ(outbox.next(), second->messages[0]);
    EXPECT_FALSE(outbox.spectrum_waiting());
    EXPECT_EQ(outbox.next(), tiles->maps[0].parts[0]);
    EXPECT_EQ(outbox.next(), nullptr);
}

TEST(Outbox, a_spectrum_is_replaced_by_a_later_one_of_its_sea_and_given_up_when_its_sea_is_over) {
    Outbox outbox;
    const EncodedSpectrumPtr coarse = spectrum_of(1, 3), fine = spectrum_of(1, 3);
    outbox.push_spectrum(coarse);
    EXPECT_EQ(outbox.next(), coarse->messages[0]);
    outbox.push_spectrum(fine);
    EXPECT_EQ(outbox.next(), fine->messages[0]) << "from its beginning";
    EXPECT_EQ(outbox.bytes_waiting(), 100u);
    for (std::uint32_t epoch = 2; epoch < 100; ++epoch)
        outbox.push_spectrum(spectrum_of(epoch, 3));
    EXPECT_EQ(outbox.bytes_waiting(), protocol::limits::spectra_max * 3u * 50)
        << "of the newest seas, however many came";
    outbox.stop_spectra();
    EXPECT_EQ(outbox.next(), nullptr);
}

// Naive: all waves of a sea to come go out at its announcement, 50 KB in an instant to everybody.
TEST(Outbox, waves_of_a_sea_to_come_go_out_by_and_by_and_are_whole_when_they_are_needed) {
    constexpr sea::TimeUs second_us = 1'000'000;
    const auto paced = [](sea::TimeUs whole_by_us) {
        auto made = std::make_shared<EncodedSpectrum>(*spectrum_of(2, 400)); // of 50 bytes each
        made->bytes = 20'000;
        made->whole_by_us = whole_by_us;
        return made;
    };
    const auto take_all = [](Outbox& outbox) {
        std::size_t bytes = 0;
        while (const protocol::SharedBytes message = outbox.next())
            bytes += message->size();
        return bytes;
    };
    const sea::TimeUs start_us = 77 * second_us;
    for (const int left_s : {5, 600}) {
        Outbox outbox;
        outbox.push_paced_spectrum(paced(start_us + left_s * second_us), start_us);
        EXPECT_FALSE(outbox.spectrum_waiting()) << "another may be asked for";
        const double bytes_per_s = left_s == 5 ? 4000 : protocol::limits::spectrum_bytes_per_s;
        std::size_t bytes = take_all(outbox);
        EXPECT_EQ(bytes, 50u) << "its head, so that it is known";
        for (int half_s = 1; outbox.paces_spectra() && half_s < 1000; ++half_s) {
            outbox.allow_spectra(start_us + half_s * second_us / 2);
            bytes += take_all(outbox);
            EXPECT_NEAR(static_cast<double>(bytes), std::min(20'000.0, bytes_per_s * half_s / 2),
                        51)
                << left_s;
        }
        EXPECT_EQ(bytes, 20'000u);
    }
    // Naive: the waves of a change that begins in nine seconds wait behind those of one that takes its time.
    Outbox both;
    both.push_paced_spectrum(paced(start_us + 600 * second_us), start_us);
    EXPECT_EQ(take_all(both), 50u);
    auto next = std::make_shared<EncodedSpectrum>(*spectrum_of(3, 2));
    next->bytes = 100;
    next->whole_by_us = start_us + 600 * second_us;
    both.push_paced_spectrum(next, start_us);
    EXPECT_EQ(take_all(both), 20'000u) << "the rest of the first, and the head of the next";
    // What should be there already goes at once, and waits for no time.
    Outbox outbox;
    outbox.push_paced_spectrum(paced(start_us), start_us);
    EXPECT_TRUE(outbox.spectrum_waiting());
    EXPECT_EQ(take_all(outbox), 20'000u);
}

} // namespace
} // namespace seaway::server
