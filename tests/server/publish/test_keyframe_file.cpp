// SPDX-License-Identifier: Apache-2.0
// Keyframes in files that are sent without copies: what lies there is what would have been written.
#include <numeric>

#include <gtest/gtest.h>
#include <unistd.h>

#include "server/publish/keyframe_file.h"
#include "server/publish/outbox.h"

namespace seaway::server {
namespace {

using protocol::SharedBytes;
using sea::Field;

/// A header that is different for each length.
void length_before(std::size_t length, protocol::Bytes& out) {
    out.push_back('#');
    if (length > 100)
        out.push_back(static_cast<std::uint8_t>(length));
}

EncodedKeyframePtr encoded_fields(sea::FieldSet fields) {
    sea::Keyframe made;
    made.size = 300; // more than a tile a side: four parts a field
    made.fields = fields;
    made.values.resize(made.plane_size() * static_cast<std::size_t>(fields.size()));
    std::iota(made.values.begin(), made.values.end(), 0.0f);
    const std::vector<float> bounds(static_cast<std::size_t>(fields.size()), 100.0f);
    return *Encoder().encode(made, bounds, 0, fields);
}

protocol::Bytes read_run(const Outbox::Run& run) {
    protocol::Bytes bytes(run.end - run.begin);
    EXPECT_EQ(
        ::pread(run.of->file->handle(), bytes.data(), bytes.size(), static_cast<off_t>(run.begin)),
        static_cast<ssize_t>(bytes.size()));
    return bytes;
}

protocol::Bytes on_the_line(const std::vector<SharedBytes>& messages) {
    protocol::Bytes bytes;
    for (const SharedBytes& message : messages) {
        length_before(message->size(), bytes);
        bytes.insert(bytes.end(), message->begin(), message->end());
    }
    return bytes;
}

class KeyframeFiles : public ::testing::Test {
  protected:
    void push(sea::FieldSet granted) { outbox.push_keyframe(keyframe, granted, file); }
    std::vector<SharedBytes> next(std::size_t most = 100) {
        std::vector<SharedBytes> messages;
        while (messages.size() < most) {
            if (SharedBytes message = outbox.next())
                messages.push_back(std::move(message));
            else
                break;
        }
        return messages;
    }

    const sea::FieldSet all{Field::height, Field::displacement_x, Field::displacement_y};
    std::shared_ptr<Room> room = Room::of(100'000'000);
    EncodedKeyframePtr keyframe = encoded_fields(all);
    KeyframeFilePtr file = keyframe_file(*keyframe, length_before, *room);
    Outbox outbox;
};

TEST_F(KeyframeFiles, the_file_has_what_would_have_been_written) {
    push(all);
    const std::vector<SharedBytes> messages = next();
    ASSERT_EQ(messages.size(), 12u);
    ASSERT_TRUE(outbox.run().of);
    EXPECT_EQ(read_run(outbox.run()), on_the_line(messages));
}

TEST_F(KeyframeFiles, some_messages_are_that_part_of_it) {
    push({Field::displacement_x, Field::displacement_y});
    for (const std::size_t count : {3u, 4u, 1u}) {
        const std::vector<SharedBytes> messages = next(count);
        ASSERT_EQ(messages.size(), count);
        ASSERT_TRUE(outbox.run().of);
        EXPECT_EQ(read_run(outbox.run()), on_the_line(messages));
        outbox.sent();
    }
}

// Naive: from the first to the last of them, with what lies between.
TEST_F(KeyframeFiles, what_is_not_one_behind_the_other_lies_in_no_file) {
    push({Field::height, Field::displacement_y});
    EXPECT_EQ(next().size(), 8u);
    EXPECT_FALSE(outbox.run().of) << "a field that was not granted is between them";
    outbox.sent();

    push(all);
    outbox.push_reply(std::make_shared<const protocol::Bytes>(protocol::pong(1, 0, 0)));
    EXPECT_EQ(next(1).size(), 1u);
    EXPECT_FALSE(outbox.run().of) << "a reply does not";
    EXPECT_EQ(next().size(), 12u);
    EXPECT_FALSE(outbox.run().of) << "nor what goes with it";
}

TEST_F(KeyframeFiles, a_file_is_held_for_as_long_as_it_is_being_sent_and_counts_until_then) {
    const std::size_t bytes = room->held_bytes();
    EXPECT_GE(bytes, keyframe->bytes);
    push(all);
    file = nullptr;
    next();
    EXPECT_EQ(room->held_bytes(), bytes);
    outbox.sent();
    EXPECT_EQ(room->held_bytes(), 0u);
}

TEST_F(KeyframeFiles, where_the_stream_has_no_memory_left_there_is_none) {
    const std::shared_ptr<Room> little = Room::of(keyframe->bytes);
    const Room::Place one = little->take_anyway(1);
    EXPECT_FALSE(keyframe_file(*keyframe, length_before, *little));
}

} // namespace
} // namespace seaway::server
