// SPDX-License-Identifier: Apache-2.0
// Outbox: spectra among what waits.
#include <gtest/gtest.h>

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
    EXPECT_EQ(outbox.bytes_waiting(), 4u * 3 * 50) << "of the four newest seas, however many came";
    outbox.stop_spectra();
    EXPECT_EQ(outbox.next(), nullptr);
}

} // namespace
} // namespace seaway::server
