// SPDX-License-Identifier: Apache-2.0
// A device that hangs: a wait for it ends, and nothing else waits for it or takes away what it may still write to. One that answers
// stands for it, of which a wait is said to have taken too long.
#include <optional>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gpu/buffer.h"
#include "gpu/call.h"
#include "gpu/commands.h"
#include "gpu/device.h"

namespace seaway::gpu {
namespace {

int calls_to_what_hangs = 0;

VkResult never_idle(VkDevice) {
    ++calls_to_what_hangs;
    return VK_SUCCESS;
}

template <class Handle>
void keep_handle(VkDevice, Handle, const VkAllocationCallbacks*) {
    ++calls_to_what_hangs;
}

template <class Whole>
void keep_whole(Whole, const VkAllocationCallbacks*) {
    ++calls_to_what_hangs;
}

/// While it is there such calls are counted and not made.
class Hangs {
  public:
    ~Hangs() {
        vkDeviceWaitIdle = wait_idle_;
        vkFreeMemory = memory_;
        vkDestroyBuffer = buffer_;
        vkDestroyCommandPool = pool_;
        vkDestroySemaphore = semaphore_;
        vkDestroyDevice = device_;
        vkDestroyInstance = instance_;
    }

  private:
    const PFN_vkDeviceWaitIdle wait_idle_ = std::exchange(vkDeviceWaitIdle, &never_idle);
    const PFN_vkFreeMemory memory_ = std::exchange(vkFreeMemory, &keep_handle<VkDeviceMemory>);
    const PFN_vkDestroyBuffer buffer_ = std::exchange(vkDestroyBuffer, &keep_handle<VkBuffer>);
    const PFN_vkDestroyCommandPool pool_ =
        std::exchange(vkDestroyCommandPool, &keep_handle<VkCommandPool>);
    const PFN_vkDestroySemaphore semaphore_ =
        std::exchange(vkDestroySemaphore, &keep_handle<VkSemaphore>);
    const PFN_vkDestroyDevice device_ = std::exchange(vkDestroyDevice, &keep_whole<VkDevice>);
    const PFN_vkDestroyInstance instance_ =
        std::exchange(vkDestroyInstance, &keep_whole<VkInstance>);
};

void expect_given_up_by(Result<void> (*first_wait)(Device&, std::uint64_t)) {
    std::unique_ptr<Device> device = Device::create({}).value();
    std::optional<Buffer> buffer =
        Buffer::create(*device, "written by what hangs", 64, BufferKind::readback).value();
    std::optional<Commands> commands = Commands::create(*device).value();
    ASSERT_TRUE(commands->begin());
    commands->fill(*buffer, 0x01020304, 64);
    ASSERT_TRUE(commands->end());
    const std::uint64_t ticket = device->submit(*commands).value();
    ASSERT_TRUE(device->wait(ticket)) << "in truth it has ended";
    {
        const Hangs hangs;
        calls_to_what_hangs = 0;
        fault::arm(1, VK_TIMEOUT);
        const Result<void> waited = first_wait(*device, ticket);
        fault::disarm();
        ASSERT_FALSE(waited);
        EXPECT_TRUE(waited.error().is(VK_TIMEOUT));
        const Result<void> again = device->wait(ticket);
        ASSERT_FALSE(again);
        EXPECT_EQ(again.error().message,
                  device->info().name + " did not answer in time, and is given up");
        EXPECT_FALSE(device->wait_transfer(1));
        EXPECT_FALSE(device->submit(*commands));
        EXPECT_FALSE(device->submit_transfer(*commands, ticket));
        EXPECT_FALSE(device->wait_idle());
        buffer.reset();
        commands.reset();
        device.reset();
        EXPECT_EQ(calls_to_what_hangs, 0) << "it may still write to all of that";
    }
}

// Naive: the wait that has ended is followed by one without an end.
TEST(GivenUp, a_device_that_does_not_answer_in_time_is_an_error_and_nobody_waits_for_it_again) {
    expect_given_up_by([](Device& device, std::uint64_t ticket) { return device.wait(ticket); });
    expect_given_up_by([](Device& device, std::uint64_t) { return device.wait_idle(); });
    const std::unique_ptr<Device> next = Device::create({}).value();
    EXPECT_TRUE(run_once(*next, [](Commands&) {})) << "another one is made, and answers";
}

TEST(GivenUp, a_device_that_is_lost_is_waited_for_and_is_not_given_up) {
    const std::unique_ptr<Device> device = Device::create({}).value();
    const Hangs counts;
    calls_to_what_hangs = 0;
    fault::arm(1, VK_ERROR_DEVICE_LOST);
    EXPECT_FALSE(device->wait(1));
    fault::disarm();
    EXPECT_EQ(calls_to_what_hangs, 1) << "until nothing of it runs";
    EXPECT_FALSE(is_given_up(device->get()));
}

} // namespace
} // namespace seaway::gpu
