// SPDX-License-Identifier: Apache-2.0
#include "sockets/frame_reader.h"

#include <algorithm>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/sockets/client_frames.h"

namespace seaway::sockets {
namespace {

using Kind = FrameReader::Kind;

/// What has come, kept beyond the next call.
struct Heard {
    Kind kind;
    FrameBytes bytes;
    bool binary;
    bool operator==(const Heard&) const = default;
};

struct Reading {
    std::vector<Heard> heard;
    std::optional<Error> error;
};

void read_on(FrameReader& reader, std::span<const std::uint8_t> bytes, Reading& reading) {
    while (!reading.error) {
        const auto next = reader.next(bytes);
        if (!next)
            reading.error = next.error();
        else if (!*next)
            return;
        else
            reading.heard.push_back(
                {(*next)->kind, {(*next)->bytes.begin(), (*next)->bytes.end()}, (*next)->binary});
    }
}

Reading read_whole(std::span<const std::uint8_t> bytes, std::size_t message_bytes_max = 200'000) {
    FrameReader reader(message_bytes_max);
    Reading reading;
    read_on(reader, bytes, reading);
    return reading;
}

FrameBytes counted(std::size_t length) {
    FrameBytes bytes(length);
    for (std::size_t i = 0; i < length; ++i)
        bytes[i] = static_cast<std::uint8_t>(i * 7 + length);
    return bytes;
}

// Whoever holds an answer back for those of the next message must not wait for one that is still on its way.
TEST(FrameReader, what_gives_a_message_is_known_beforehand) {
    for (const std::size_t length : {0, 5, 125, 126, 70'000}) {
        const FrameBytes whole = client_frame(counted(length));
        EXPECT_TRUE(FrameReader::gives_message(whole)) << length;
        for (const std::size_t cut : {std::size_t{0}, std::size_t{1}, std::size_t{3},
                                      whole.size() - length - 1, whole.size() - 1})
            EXPECT_FALSE(FrameReader::gives_message(std::span(whole).first(cut)))
                << cut << " of " << whole.size();
    }
    EXPECT_FALSE(FrameReader::gives_message(client_frame(counted(5), {.last = false})));
    EXPECT_TRUE(FrameReader::gives_message(client_frame(counted(5), {.opcode = 0})))
        << "the last part of one, or an error";
    for (const std::uint8_t control : {8, 9, 10})
        EXPECT_FALSE(FrameReader::gives_message(client_frame(counted(5), {.opcode = control})));
}

// RFC 6455, 5.7: the masked examples of the standard itself.
TEST(FrameReader, the_examples_of_the_standard_are_read) {
    const FrameBytes hello{0x81, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58};
    const FrameBytes pong{0x8a, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58};
    const FrameBytes word{'H', 'e', 'l', 'l', 'o'};
    EXPECT_EQ(read_whole(hello).heard, (std::vector<Heard>{{Kind::message, word, false}}));
    EXPECT_EQ(read_whole(pong).heard, (std::vector<Heard>{{Kind::pong, word, true}}));
}

// Lengths at which a header changes, in any pieces.
TEST(FrameReader, messages_are_the_same_in_whatever_pieces_they_come) {
    FrameBytes stream;
    std::vector<Heard> sent;
    for (const std::size_t length : {0, 1, 7, 8, 9, 125, 126, 127, 65535, 65536, 70'001}) {
        const FrameBytes payload = counted(length);
        append_client_frame(stream, payload);
        sent.push_back({Kind::message, payload, true});
    }
    EXPECT_EQ(read_whole(stream).heard, sent);
    std::mt19937_64 numbers(5);
    for (const std::size_t most : {1u, 2u, 3u, 5u, 13u, 4096u, 16384u}) {
        FrameReader reader(200'000, 1000);
        Reading reading;
        for (std::span<const std::uint8_t> left(stream); !left.empty();) {
            const std::size_t piece = std::min<std::size_t>(1 + numbers() % most, left.size());
            read_on(reader, left.first(piece), reading);
            left = left.subspan(piece);
        }
        EXPECT_FALSE(reading.error);
        EXPECT_EQ(reading.heard, sent) << "pieces of up to " << most;
    }
}

TEST(FrameReader, control_frames_come_between_the_parts_of_a_message) {
    FrameBytes stream;
    append_client_frame(stream, counted(10), {.opcode = 2, .last = false});
    append_client_frame(stream, counted(3), {.opcode = 9});
    append_client_frame(stream, counted(0), {.opcode = 0, .last = false});
    append_client_frame(stream, counted(125), {.opcode = 10});
    append_client_frame(stream, counted(200), {.opcode = 0});
    append_client_frame(stream, counted(1), {.opcode = 1});
    FrameBytes whole = counted(10);
    const FrameBytes rest = counted(200);
    whole.insert(whole.end(), rest.begin(), rest.end());
    EXPECT_EQ(read_whole(stream).heard, (std::vector<Heard>{{Kind::ping, counted(3), true},
                                                            {Kind::pong, counted(125), true},
                                                            {Kind::message, whole, true},
                                                            {Kind::message, counted(1), false}}));
}

struct Wrong {
    const char* what;
    FrameBytes bytes;
};

std::vector<Wrong> against_the_standard() {
    const auto of = [](std::initializer_list<int> bytes) {
        FrameBytes made;
        for (const int byte : bytes)
            made.push_back(static_cast<std::uint8_t>(byte));
        return made;
    };
    FrameBytes within = client_frame(counted(1), {.opcode = 2, .last = false});
    append_client_frame(within, counted(1), {.opcode = 2});
    return {
        {"no mask", of({0x82, 0x01})},
        {"reserved bit 1", of({0xc2, 0x81})},
        {"reserved bit 2", of({0xa2, 0x81})},
        {"reserved bit 3", of({0x92, 0x81})},
        {"unknown kind 3", of({0x83, 0x80})},
        {"unknown kind 7", of({0x87, 0x80})},
        {"unknown kind 11", of({0x8b, 0x80})},
        {"unknown kind 15", of({0x8f, 0x80})},
        {"a continuation of nothing", of({0x80, 0x80})},
        {"a message within a message", within},
        {"a ping in parts", of({0x09, 0x80})},
        {"a ping of 126 bytes", of({0x89, 0xfe})},
        {"2 bytes for a length of 125", of({0x82, 0xfe, 0, 125, 1, 2, 3, 4})},
        {"8 bytes for a length of 65535",
         of({0x82, 0xff, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 1, 2, 3, 4})},
        {"a length of 2^63", of({0x82, 0xff, 0x80, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4})},
    };
}

TEST(FrameReader, what_is_against_the_standard_is_an_error_as_soon_as_it_is_known) {
    for (const Wrong& wrong : against_the_standard()) {
        const Reading reading = read_whole(wrong.bytes);
        ASSERT_TRUE(reading.error) << wrong.what;
        EXPECT_TRUE(reading.error->is(BadFrame::against_protocol)) << wrong.what;
        EXPECT_TRUE(reading.heard.empty()) << wrong.what;
    }
}

TEST(FrameReader, a_message_above_the_limit_is_an_error_before_its_first_byte) {
    EXPECT_FALSE(read_whole(client_frame(counted(1000)), 1000).error);
    FrameBytes above = client_frame(counted(1001));
    above.resize(8); // its header
    FrameBytes in_parts = client_frame(counted(600), {.opcode = 2, .last = false});
    FrameBytes second = client_frame(counted(401), {.opcode = 0});
    in_parts.insert(in_parts.end(), second.begin(), second.begin() + 8);
    const FrameBytes huge{0x82, 0xff, 0x40, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4};
    for (const FrameBytes& bytes : {above, in_parts, huge}) {
        const Reading reading = read_whole(bytes, 1000);
        ASSERT_TRUE(reading.error);
        EXPECT_TRUE(reading.error->is(BadFrame::too_large)) << reading.error->message;
    }
}

// RFC 6455, 5.5.1 and 7.4, and 3629 for the reason.
TEST(FrameReader, closing_frames_are_held_to_the_standard) {
    const auto closing = [](unsigned code, const std::string& reason) {
        FrameBytes bytes{static_cast<std::uint8_t>(code >> 8), static_cast<std::uint8_t>(code)};
        bytes.insert(bytes.end(), reason.begin(), reason.end());
        return read_close(bytes);
    };
    EXPECT_EQ(read_close({})->code, 0u);
    EXPECT_FALSE(read_close(FrameBytes{3}));
    for (const unsigned code : {1000u, 1001u, 1003u, 1007u, 1011u, 1014u, 3000u, 4001u, 4999u})
        EXPECT_TRUE(closing(code, "")) << code;
    for (const unsigned code : {0u, 999u, 1004u, 1005u, 1006u, 1015u, 2999u, 5000u, 65535u})
        EXPECT_FALSE(closing(code, "")) << code;
    EXPECT_EQ(closing(1000, "grüße 波 🌊")->reason, "grüße 波 🌊");
    for (const char* wrong :
         {"\x80", "\xc0\x80", "\xc3", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf0\x8f\xbf\xbf",
          "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "a\xe2\x82"})
        EXPECT_FALSE(closing(1000, wrong)) << wrong;
}

TEST(FrameReader, a_reason_too_long_for_a_frame_is_cut_between_characters) {
    const auto sent = [](const std::string& reason) {
        const FrameBytes frame = close_frame({4001, reason});
        EXPECT_EQ(frame[0], 0x88);
        EXPECT_EQ(frame[1], frame.size() - 2);
        return read_close(std::span(frame).subspan(2));
    };
    EXPECT_EQ(sent(std::string(200, 'x'))->reason, std::string(123, 'x'));
    EXPECT_EQ(sent(std::string(122, 'x') + "ü")->reason, std::string(122, 'x'));
    EXPECT_EQ(sent(std::string(121, 'x') + "ü")->reason, std::string(121, 'x') + "ü");
    EXPECT_EQ(close_frame({}), (FrameBytes{0x88, 0}));
}

// Whatever comes: no crash, no message above the limit, no end without progress.
TEST(FrameReader, noise_ends_in_messages_or_an_error) {
    std::mt19937_64 numbers(11);
    for (int round = 0; round < 20'000; ++round) {
        FrameBytes bytes = client_frame(counted(numbers() % 300));
        append_client_frame(bytes, counted(numbers() % 120), {.opcode = 9});
        for (int flips = static_cast<int>(numbers() % 4); flips >= 0; --flips)
            bytes[numbers() % std::min<std::size_t>(bytes.size(), 16)] ^=
                static_cast<std::uint8_t>(1u << numbers() % 8);
        for (const Heard& heard : read_whole(bytes, 250).heard)
            EXPECT_LE(heard.bytes.size(), 250u);
    }
}

} // namespace
} // namespace seaway::sockets
