// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include "gpu/buffer.h"
#include "gpu/call.h"
#include "gpu/commands.h"
#include "gpu/image.h"
#include "gpu/timer.h"
#include "tests/gpu/device_for_tests.h"

namespace seaway::gpu {
namespace {

using testing::HasSubstr;

DeviceInfo named(int index, const char* name, VkPhysicalDeviceType type) {
    DeviceInfo info;
    info.index = index;
    info.name = name;
    info.type = type;
    return info;
}

const std::vector<DeviceInfo> three_devices{
    named(0, "lavapipe (llvmpipe)", VK_PHYSICAL_DEVICE_TYPE_CPU),
    named(1, "Intel UHD 770", VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU),
    named(2, "NVIDIA L4", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU)};

TEST(PickDevice, auto_takes_the_discrete_device_and_never_an_unusable_one) {
    EXPECT_EQ(*pick_device(three_devices, "auto"), 2);
    std::vector<DeviceInfo> devices = three_devices;
    devices[2].unusable = "Vulkan 1.1, 1.3 needed";
    EXPECT_EQ(*pick_device(devices, "auto"), 1);
    EXPECT_THAT(pick_device(devices, "2").error().message, HasSubstr("1.3 needed"));
}

// Naive: a GPU for computing alone hides the one beside it that could have drawn.
TEST(PickDevice, who_draws_gets_a_device_that_can) {
    std::vector<DeviceInfo> devices = three_devices;
    devices[0].graphics = devices[1].graphics = true;
    EXPECT_EQ(*pick_device(devices, "auto"), 2);
    EXPECT_EQ(*pick_device(devices, "auto", true), 1);
    EXPECT_THAT(pick_device(devices, "L4", true).error().message, HasSubstr("it cannot draw"));
    devices[0].graphics = devices[1].graphics = false;
    EXPECT_THAT(pick_device(devices, "auto", true).error().message,
                HasSubstr("no usable Vulkan device that can draw; there are: 0 = lavapipe"));
}

TEST(PickDevice, of_equals_the_first_is_taken) {
    std::vector<DeviceInfo> devices = three_devices;
    devices.push_back(named(3, "NVIDIA L4", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU));
    EXPECT_EQ(*pick_device(devices, "auto"), 2);
    EXPECT_EQ(*pick_device(devices, "l4"), 2);
}

TEST(PickDevice, an_index_or_a_part_of_a_name_picks) {
    EXPECT_EQ(*pick_device(three_devices, "1"), 1);
    EXPECT_EQ(*pick_device(three_devices, "LAVApipe"), 0);
    EXPECT_EQ(*pick_device(three_devices, "uhd 7"), 1);
}

TEST(PickDevice, every_letter_may_be_large_or_small_on_either_side) {
    for (char letter = 'a'; letter <= 'z'; ++letter) {
        const std::string small(1, letter);
        const std::string large(1, static_cast<char>(letter - 'a' + 'A'));
        for (const std::string& name : {small, large})
            for (const std::string& wish : {small, large})
                EXPECT_TRUE(pick_device(
                    std::vector{named(0, name.c_str(), VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU)},
                    wish))
                    << wish << " for " << name;
    }
}

TEST(PickDevice, an_unknown_wish_lists_what_there_is) {
    EXPECT_THAT(pick_device(three_devices, "radeon").error().message, HasSubstr("2 = NVIDIA L4"));
    EXPECT_FALSE(pick_device(three_devices, "7"));
    EXPECT_FALSE(pick_device(three_devices, ""));
    EXPECT_FALSE(pick_device({}, "auto"));
}

VkQueueFamilyProperties family(VkQueueFlags flags, std::uint32_t queues = 1) {
    return {.queueFlags = flags, .queueCount = queues};
}

TEST(TransferFamily, is_one_that_copies_and_does_nothing_else) {
    constexpr VkQueueFlags all =
        VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
    constexpr VkQueueFlags computes = VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
    constexpr VkQueueFlags copies = VK_QUEUE_TRANSFER_BIT | VK_QUEUE_SPARSE_BINDING_BIT;
    EXPECT_EQ(pick_transfer_family(std::vector{family(all)}), std::nullopt) << "as lavapipe has it";
    EXPECT_EQ(pick_transfer_family(std::vector{family(all), family(computes)}), std::nullopt);
    EXPECT_EQ(pick_transfer_family(std::vector{family(all), family(computes), family(copies)}), 2u);
    EXPECT_EQ(pick_transfer_family(std::vector{family(copies, 0), family(copies), family(all)}), 1u)
        << "a family without queues is none";
    const auto video = family(copies | VK_QUEUE_VIDEO_DECODE_BIT_KHR);
    EXPECT_EQ(pick_transfer_family(std::vector{family(all), video}), std::nullopt);
    EXPECT_EQ(pick_transfer_family(std::vector{family(all), video, family(copies)}), 2u);
    EXPECT_EQ(pick_transfer_family(std::vector{family(VK_QUEUE_SPARSE_BINDING_BIT)}), std::nullopt);
    EXPECT_EQ(pick_transfer_family({}), std::nullopt);
}

// Each queue counts for itself: a copy that ends late does not hold up, nor overtake, what the main queue has done.
TEST_F(DeviceTest,
       a_copy_of_the_transfer_queue_follows_what_it_waits_for_and_has_tickets_of_its_own) {
    constexpr std::size_t bytes = 1 << 20;
    // Of its own, whose tickets begin.
    const std::unique_ptr<Device> device = Device::create({.validation = true}).value();
    Buffer from = Buffer::create(*device, "from", bytes, BufferKind::device).value();
    Buffer to = Buffer::create(*device, "to", bytes, BufferKind::readback).value();
    Commands writes = Commands::create(*device).value(), more = Commands::create(*device).value();
    Commands copies = Commands::create(*device, Queue::transfer).value();
    std::uint64_t copied = 0;
    for (const std::uint32_t word : {0x01020304u, 0xfedcba98u}) {
        ASSERT_TRUE(writes.begin());
        writes.fill(from, word, bytes);
        ASSERT_TRUE(writes.end());
        ASSERT_TRUE(copies.begin());
        copies.copy(from, to, bytes);
        copies.barrier(Stage::copy, Stage::host);
        ASSERT_TRUE(copies.end());
        ASSERT_TRUE(more.begin());
        ASSERT_TRUE(more.end());
        const std::uint64_t written = device->submit(writes).value();
        const std::uint64_t ticket = device->submit_transfer(copies, written).value();
        EXPECT_EQ(ticket, ++copied);
        EXPECT_TRUE(device->wait(device->submit(more).value()));
        ASSERT_TRUE(device->wait_transfer(ticket));
        EXPECT_EQ(std::ranges::count(to.mapped_as<std::uint32_t>(), word),
                  static_cast<std::ptrdiff_t>(bytes / sizeof(word)));
    }
    expect_no_messages(device->validation());
}

TEST(ListDevices, finds_one_that_can_be_used) {
    const Result<std::vector<DeviceInfo>> devices = list_devices();
    ASSERT_TRUE(devices) << devices.error().message;
    EXPECT_TRUE(pick_device(*devices, "auto"));
}

TEST(PickDevice, what_there_is_says_why_which_cannot_be_used) {
    std::vector<DeviceInfo> devices = three_devices;
    devices[1].unusable = "no compute queue";
    const std::string list =
        "0 = lavapipe (llvmpipe), 1 = Intel UHD 770 [no compute queue], 2 = NVIDIA L4";
    for (const char* wish : {"radeon", "7"})
        EXPECT_THAT(pick_device(devices, wish).error().message, HasSubstr(list)) << wish;
}

TEST_F(DeviceTest, bytes_go_to_the_device_and_come_back) {
    std::vector<std::byte> sent(100'003);
    for (std::size_t i = 0; i < sent.size(); ++i)
        sent[i] = static_cast<std::byte>(i * 7);
    for (const BufferKind kind : {BufferKind::device, BufferKind::upload, BufferKind::readback}) {
        Result<Buffer> buffer = Buffer::create(*device_, "there", sent.size(), kind);
        ASSERT_TRUE(buffer) << buffer.error().message;
        ASSERT_TRUE(upload(*device_, *buffer, sent));
        std::vector<std::byte> back(sent.size());
        ASSERT_TRUE(download(*device_, *buffer, back));
        EXPECT_EQ(back, sent);
    }
}

TEST_F(DeviceTest, copies_obey_offsets_and_the_timer_counts_forward) {
    Result<Buffer> from = Buffer::create(*device_, "from", 64, BufferKind::upload);
    Result<Buffer> to = Buffer::create(*device_, "to", 64, BufferKind::readback);
    ASSERT_TRUE(from && to);
    std::memset(from->mapped().data(), 5, 64);
    std::memset(to->mapped().data(), 0, 64);
    Result<Timer> timer = Timer::create(*device_, 2);
    ASSERT_TRUE(timer);
    ASSERT_TRUE(run_once(*device_, [&](Commands& commands) {
        timer->reset(commands);
        timer->stamp(commands);
        commands.copy(*from, *to, 8, 0, 16);
        commands.barrier(Stage::copy, Stage::host);
        timer->stamp(commands);
    }));
    EXPECT_EQ(to->mapped()[15], std::byte{0});
    EXPECT_EQ(to->mapped()[16], std::byte{5});
    EXPECT_EQ(to->mapped()[23], std::byte{5});
    EXPECT_EQ(to->mapped()[24], std::byte{0});
    const Result<std::vector<double>> seconds = timer->read(*device_);
    ASSERT_TRUE(seconds);
    ASSERT_EQ(seconds->size(), 1u);
    EXPECT_GE((*seconds)[0], 0);
    EXPECT_LT((*seconds)[0], 60) << "of two copies of some bytes";
}

// No device copies 64 MiB within a tick of its clock, if it has one.
TEST_F(DeviceTest, a_large_copy_takes_some_time) {
    constexpr std::size_t bytes = 64u << 20;
    Result<Buffer> from = Buffer::create(*device_, "from", bytes, BufferKind::device);
    Result<Buffer> to = Buffer::create(*device_, "to", bytes, BufferKind::device);
    ASSERT_TRUE(from && to);
    Result<Timer> timer = Timer::create(*device_, 2);
    ASSERT_TRUE(timer);
    ASSERT_TRUE(run_once(*device_, [&](Commands& commands) {
        timer->reset(commands);
        timer->stamp(commands);
        commands.copy(*from, *to, bytes);
        commands.barrier(Stage::copy, Stage::copy);
        timer->stamp(commands);
    }));
    const Result<std::vector<double>> seconds = timer->read(*device_);
    ASSERT_TRUE(seconds);
    EXPECT_EQ((*seconds)[0] > 0, device_->time_stamp_bits() > 0);
}

// Of 36 bits, the fewest that a queue has, a clock of 1 ns goes round every 69 s.
TEST(Timer, spans_go_on_where_the_clock_of_a_device_begins_anew) {
    constexpr std::uint64_t round = std::uint64_t{1} << 36;
    EXPECT_EQ(ticks_between(round - 5, 3, 36), 8u);
    EXPECT_EQ(ticks_between(3, 8, 36), 5u);
    EXPECT_EQ(ticks_between(7, 7, 36), 0u);
    EXPECT_EQ(ticks_between(~std::uint64_t{0}, 1, 64), 2u);
}

// Naive: each span from the first stamp on; of twenty, the first one counts nineteen times.
TEST_F(DeviceTest, spans_of_the_timer_add_up_to_no_more_than_the_time_that_passed) {
    constexpr std::size_t bytes = std::size_t{16} << 20;
    Result<Buffer> from = Buffer::create(*device_, "from", bytes, BufferKind::device);
    Result<Buffer> to = Buffer::create(*device_, "to", bytes, BufferKind::device);
    ASSERT_TRUE(from && to);
    constexpr std::uint32_t stamps = 20;
    Result<Timer> timer = Timer::create(*device_, stamps);
    ASSERT_TRUE(timer);
    const auto start = std::chrono::steady_clock::now();
    ASSERT_TRUE(run_once(*device_, [&](Commands& commands) {
        timer->reset(commands);
        timer->stamp(commands);
        for (int copy = 0; copy < 16; ++copy) {
            commands.copy(*from, *to, bytes);
            commands.barrier(Stage::copy, Stage::copy);
        }
        for (std::uint32_t i = 1; i < stamps; ++i)
            timer->stamp(commands);
    }));
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    const Result<std::vector<double>> seconds = timer->read(*device_);
    ASSERT_TRUE(seconds);
    ASSERT_EQ(seconds->size(), stamps - 1);
    EXPECT_LE(std::accumulate(seconds->begin(), seconds->end(), 0.0), passed.count());
}

TEST_F(DeviceTest, a_buffer_larger_than_memory_is_an_error_that_names_it) {
    const Result<Buffer> buffer =
        Buffer::create(*device_, "whole world", std::size_t{1} << 46, BufferKind::device);
    ASSERT_FALSE(buffer);
    EXPECT_THAT(buffer.error().message, HasSubstr("whole world"));
}

TEST_F(DeviceTest, a_buffer_above_the_limit_of_the_device_is_refused_before_the_driver_is_asked) {
    // To ask would be a mistake by the rules of Vulkan, which newer validation layers report.
    ASSERT_GE(device_->buffer_bytes_max(), std::uint64_t{1} << 30); // what Vulkan 1.3 promises
    if (device_->buffer_bytes_max() == ~std::uint64_t{0})
        return; // no size is above it
    const std::size_t bytes = device_->buffer_bytes_max() + 1;
    const Result<Buffer> buffer = Buffer::create(*device_, "too long", bytes, BufferKind::device);
    ASSERT_FALSE(buffer);
    EXPECT_EQ(buffer.error().message, "buffer \"too long\", " + std::to_string(bytes) +
                                          " bytes: " + device_->info().name + " allows " +
                                          std::to_string(bytes - 1));
}

// Naive: a still that two cores draw for more than a minute is taken for a hang.
TEST_F(DeviceTest, a_processor_that_draws_is_waited_for_as_long_as_it_takes) {
    EXPECT_EQ(std::isinf(device_->patience_s()), device_->info().is_cpu());
    EXPECT_GE(device_->patience_s(), 60);
}

TEST(Staged, bytes_go_round_through_staging_buffers_as_on_a_discrete_device) {
    Result<std::unique_ptr<Device>> device = Device::create({.validation = true, .staged = true});
    ASSERT_TRUE(device) << device.error().message;
    Result<Buffer> buffer = Buffer::create(**device, "far", 4096, BufferKind::device);
    ASSERT_TRUE(buffer) << buffer.error().message;
    EXPECT_TRUE(buffer->mapped().empty());
    std::vector<std::byte> sent(4096, std::byte{0x5a}), back(4096);
    ASSERT_TRUE(upload(**device, *buffer, sent));
    ASSERT_TRUE(download(**device, *buffer, back));
    EXPECT_EQ(back, sent);
    EXPECT_THAT((*device)->validation().validation_messages(), testing::IsEmpty());
}

TEST(Image, mips_go_down_to_a_single_texel_of_the_longer_side) {
    EXPECT_EQ(full_mip_count(1, 1), 1u);
    EXPECT_EQ(full_mip_count(64, 64), 7u);
    EXPECT_EQ(full_mip_count(64, 16), 7u);
    EXPECT_EQ(full_mip_count(3, 130), 8u);
}

// An image that is wider than high, of two layers, comes back mip by mip as it was sent: the packing that
// texel_count() tells.
TEST_F(DeviceTest, every_mip_and_layer_of_an_image_holds_its_own_texels) {
    const ImageSpec spec{.width = 32,
                         .height = 8,
                         .layers = 2,
                         .mips = 4,
                         .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                  VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                         .array = true};
    Result<Image> image = Image::create(*device_, "wide", spec);
    ASSERT_TRUE(image) << image.error().message;
    constexpr std::size_t texels = 2 * (32 * 8 + 16 * 4 + 8 * 2 + 4 * 1), texel_bytes = 16;
    ASSERT_EQ(image->texel_count(), texels);
    Result<Buffer> sent =
        Buffer::create(*device_, "sent", texels * texel_bytes, BufferKind::upload);
    ASSERT_TRUE(sent);
    std::vector<float> numbers(4 * texels);
    std::iota(numbers.begin(), numbers.end(), 1.0f);
    std::memcpy(sent->mapped().data(), numbers.data(), 4 * numbers.size());
    std::size_t first = 0;
    for (std::uint32_t mip = 0; mip < spec.mips; ++mip) {
        const std::uint32_t width = 32u >> mip, height = 8u >> mip;
        const std::size_t count = std::size_t{4} * 2 * width * height;
        Result<Buffer> back =
            Buffer::create(*device_, "back", count * sizeof(float), BufferKind::readback);
        ASSERT_TRUE(back);
        ASSERT_TRUE(run_once(*device_, [&](Commands& commands) {
            record_upload(commands, *sent, *image, texel_bytes);
            record_transition(commands, *image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                              VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
            const VkBufferImageCopy region{
                .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, mip, 0, 2},
                .imageExtent = {width, height, 1}};
            vkCmdCopyImageToBuffer(commands.get(), image->get(),
                                   VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, back->get(), 1, &region);
            commands.barrier(Stage::copy, Stage::host);
        }));
        std::vector<float> held(count);
        std::memcpy(held.data(), back->mapped().data(), count * sizeof(float));
        const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(first);
        EXPECT_TRUE(std::equal(held.begin(), held.end(), begin)) << "mip " << mip;
        first += count;
    }
    EXPECT_EQ(first, numbers.size());
}

TEST(Validation, a_mistake_is_counted) {
    Result<std::unique_ptr<Device>> device = Device::create({.validation = true});
    ASSERT_TRUE(device) << device.error().message;
    Result<Commands> commands = Commands::create(**device);
    ASSERT_TRUE(commands);
    EXPECT_TRUE(commands->begin());
    Result<Buffer> buffer = Buffer::create(**device, "small", 16, BufferKind::device);
    ASSERT_TRUE(buffer);
    commands->copy(*buffer, *buffer, 64); // beyond both ends
    EXPECT_TRUE(commands->end());
    EXPECT_GT((*device)->validation().validation_message_count(), 0u);
}

TEST(Fault, the_nth_call_fails_and_the_next_ones_do_not_unless_asked) {
    const auto made = [](int) { return VK_SUCCESS; };
    fault::arm(2, VK_ERROR_DEVICE_LOST);
    EXPECT_TRUE(call("first", made, 1));
    const Result<void> second = call("second", made, 2);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().message, "second: device lost (VK_ERROR_DEVICE_LOST)");
    EXPECT_TRUE(call("third", made, 3));
    EXPECT_EQ(fault::calls(), 3u);
    fault::arm(1, VK_ERROR_OUT_OF_HOST_MEMORY, true);
    EXPECT_FALSE(call("first", made, 1));
    EXPECT_FALSE(call("second", made, 2));
    fault::disarm();
    EXPECT_TRUE(call("calm again", made, 3));
}

} // namespace
} // namespace seaway::gpu
