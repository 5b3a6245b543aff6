// SPDX-License-Identifier: Apache-2.0
#include "gpu/timer.h"

#include "base/check.h"
#include "gpu/call.h"

namespace seaway::gpu {

Result<Timer> Timer::create(Device& device, std::uint32_t stamps) {
    Timer made;
    made.capacity_ = stamps;
    if (device.time_stamp_bits() == 0)
        return made;
    made.bits_ = device.time_stamp_bits();
    made.tick_s_ = static_cast<double>(device.limits().timestampPeriod) * 1e-9;
    const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                     .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                     .queryCount = stamps};
    VkQueryPool pool = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateQueryPool", vkCreateQueryPool, device.get(), &info, nullptr, &pool));
    made.pool_ = OwnedQueryPool(device.get(), pool);
    return made;
}

void Timer::reset(Commands& commands) {
    used_ = 0;
    if (pool_)
        vkCmdResetQueryPool(commands.get(), pool_.get(), 0, capacity_);
}

void Timer::stamp(Commands& commands) {
    SEAWAY_CHECK(used_ < capacity_, "more time stamps than the timer has room for");
    if (pool_)
        vkCmdWriteTimestamp2(commands.get(), VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_.get(),
                             used_);
    ++used_;
}

Result<std::vector<double>> Timer::read(Device& device) const {
    if (used_ < 2)
        return std::vector<double>{};
    std::vector<std::uint64_t> ticks(used_, 0);
    if (pool_)
        SEAWAY_TRY(call("vkGetQueryPoolResults", vkGetQueryPoolResults, device.get(), pool_.get(),
                        0u, used_, ticks.size() * sizeof(ticks[0]),
                        static_cast<void*>(ticks.data()), VkDeviceSize{sizeof(ticks[0])},
                        VkQueryResultFlags{VK_QUERY_RESULT_64_BIT}));
    std::vector<double> seconds;
    for (std::size_t i = 1; i < ticks.size(); ++i)
        seconds.push_back(static_cast<double>(ticks_between(ticks[i - 1], ticks[i], bits_)) *
                          tick_s_);
    return seconds;
}

} // namespace seaway::gpu
