// SPDX-License-Identifier: Apache-2.0
// Commands: one command buffer. Record, then Device::submit; a recording may be submitted again and
// again. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/result.h"
#include "gpu/buffer.h"
#include "gpu/device.h"
#include "gpu/kernel.h"

namespace seaway::gpu {

/// Who writes or reads on either side of a barrier.
enum class Stage { compute, copy, host, graphics };

/// Which of a device's queues a recording is for.
enum class Queue { main, transfer };

/// Groups a row and rows for so many invocations: no more a row than every device takes (Vulkan 1.3, Required Limits:
/// maxComputeWorkGroupCount is at least 65535), and fewer than one row too many.
struct FlatGroups {
    static constexpr std::size_t row_max = 65535;
    std::uint32_t a_row = 1, rows = 1;
};
FlatGroups flat_groups(std::size_t invocations, int group);

class Commands {
  public:
    Commands() = default;
    static Result<Commands> create(Device& device, Queue queue = Queue::main);

    /// Starts anew, also in the middle of a recording; whatever was submitted must have finished.
    Result<void> begin();
    Result<void> end();

    /// All writes of `from` are seen by `to`.
    void barrier(Stage from, Stage to);
    void copy(const Buffer& source, const Buffer& target, std::size_t bytes,
              std::size_t source_offset = 0, std::size_t target_offset = 0);
    /// Writes one word over and over; both a multiple of 4 bytes.
    void fill(const Buffer& target, std::uint32_t word, std::size_t bytes, std::size_t offset = 0);
    /// Writes up to 64 KiB that travel in the recording itself; a multiple of 4 bytes.
    void update(const Buffer& target, std::span<const std::byte> bytes);
    /// Groups, not invocations, and no more a side than the device takes. `push` must be as long as the kernel's push
    /// constants.
    void dispatch(const Kernel& kernel, const Bindings& bindings, std::span<const std::byte> push,
                  std::uint32_t groups_x, std::uint32_t groups_y = 1, std::uint32_t groups_z = 1);

    /// At least so many invocations a layer, of a kernel whose groups are one wide row, in as many rows of groups as
    /// devices must take: shaders/view/flat.glsl numbers them. Layers are along z.
    void dispatch_all(const Kernel& kernel, const Bindings& bindings,
                      std::span<const std::byte> push, std::size_t invocations, int group,
                      std::uint32_t layers = 1);

    /// Others record with it what this class does not do: drawing, image copies.
    VkCommandBuffer get() const { return buffer_; }

  private:
    OwnedCommandPool pool_;
    VkDevice device_ = VK_NULL_HANDLE;
    VkCommandBuffer buffer_ = VK_NULL_HANDLE; // owned by the pool
    std::array<std::uint32_t, 3> groups_max_{};
    bool recording_ = false;
};

/// Records, submits and waits.
Result<void> run_once(Device& device, const std::function<void(Commands&)>& record);

} // namespace seaway::gpu
