// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/yardsticks/mover.h"

#include <chrono>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/thread_pool.h"
#include "gpu/commands.h"
#include "gpu/device.h"
#include "gpu/kernel.h"
#include "gpu/timer.h"
#include "shaders/shared/synthesis.h"
#include "shaders/synthesis.h"

namespace seaway::bench {

namespace {

using Clock = std::chrono::steady_clock;

/// All threads, each its part.
class Stores final : public Mover {
  public:
    std::string name() const override {
        return fmt::format("stores of {} threads", pool_.threads());
    }
    Result<double> seconds(std::size_t bytes) override {
        const Work work{memory_, bytes / static_cast<std::size_t>(pool_.threads())};
        const Phase store{[](const void* context, int chunk, int) {
                              const Work& own = *static_cast<const Work*>(context);
                              std::memset(own.memory.data() +
                                              static_cast<std::size_t>(chunk) * own.part,
                                          chunk + 1, own.part);
                          },
                          &work, pool_.threads()};
        const auto start = Clock::now();
        pool_.run({&store, 1});
        return seconds_since(start);
    }

  private:
    struct Work {
        std::vector<char>& memory;
        std::size_t part;
    };
    ThreadPool pool_;
    mutable std::vector<char> memory_ = std::vector<char>(moved_bytes);
};

/// A kernel that reads as synthesis kernels do, and writes.
class Copies final : public Mover {
  public:
    static Result<std::unique_ptr<Mover>> create(const std::string& pick) {
        std::unique_ptr<Copies> made(new Copies);
        SEAWAY_TRY_LET(made->device_, gpu::Device::create({.pick = pick}));
        gpu::Device& device = *made->device_;
        SEAWAY_TRY_LET(
            made->kernel_,
            gpu::Kernel::create(device, shaders::copy().name, shaders::copy().spirv,
                                {.bindings = {{"source", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                                              {"Target", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}},
                                 .push_constant_bytes = 0,
                                 .local_size = {shaders::synthesis_workgroup, 1, 1}}));
        for (gpu::Buffer* buffer : {&made->from_, &made->to_}) {
            SEAWAY_TRY_LET(*buffer, gpu::Buffer::create(device, "copied", moved_bytes,
                                                        gpu::BufferKind::device));
        }
        SEAWAY_TRY_LET(made->view_,
                       gpu::TexelView::create(device, made->from_, VK_FORMAT_R32G32B32A32_SFLOAT,
                                              texel, 0, moved_bytes));
        SEAWAY_TRY_LET(made->bindings_, made->kernel_.bind(device, {gpu::texels(made->view_),
                                                                    gpu::whole(made->to_)}));
        SEAWAY_TRY_LET(made->commands_, gpu::Commands::create(device));
        SEAWAY_TRY_LET(made->timer_, gpu::Timer::create(device, 2));
        made->stamped_ = !device.info().is_cpu() && device.time_stamp_bits() > 0;
        SEAWAY_TRY(gpu::run_once(
            device, [&](gpu::Commands& commands) { commands.fill(made->from_, 0, moved_bytes); }));
        return std::unique_ptr<Mover>(std::move(made));
    }
    std::string name() const override { return "a copy kernel"; }
    Result<double> seconds(std::size_t bytes) override {
        SEAWAY_TRY(commands_.begin());
        if (stamped_) {
            timer_.reset(commands_);
            timer_.stamp(commands_);
        }
        commands_.dispatch_all(kernel_, bindings_, {}, bytes / texel, shaders::synthesis_workgroup);
        if (stamped_)
            timer_.stamp(commands_);
        commands_.barrier(gpu::Stage::compute, gpu::Stage::host);
        SEAWAY_TRY(commands_.end());
        const auto start = Clock::now();
        SEAWAY_TRY(device_->submit_and_wait(commands_));
        const double wall_s = seconds_since(start);
        if (!stamped_)
            return wall_s;
        SEAWAY_TRY_LET(const std::vector<double> passes_s, timer_.read(*device_));
        return passes_s.at(0);
    }

  private:
    static constexpr std::size_t texel = 16;
    Copies() = default;
    std::unique_ptr<gpu::Device> device_;
    gpu::Kernel kernel_;
    gpu::Buffer from_, to_;
    gpu::TexelView view_;
    gpu::Bindings bindings_;
    gpu::Commands commands_;
    gpu::Timer timer_;
    bool stamped_ = false; ///< as synthesis is timed (VulkanBatch::time_passes)
};

class Readbacks final : public Mover {
  public:
    static Result<std::unique_ptr<Mover>> create(const std::string& pick) {
        std::unique_ptr<Readbacks> made(new Readbacks);
        SEAWAY_TRY_LET(made->device_, gpu::Device::create({.pick = pick, .staged = true}));
        gpu::Device& device = *made->device_;
        SEAWAY_TRY_LET(made->from_, gpu::Buffer::create(device, "read back", moved_bytes,
                                                        gpu::BufferKind::device));
        SEAWAY_TRY_LET(made->by_, gpu::Buffer::create(device, "readback", moved_bytes,
                                                      gpu::BufferKind::readback));
        SEAWAY_TRY_LET(made->commands_, gpu::Commands::create(device));
        SEAWAY_TRY(gpu::run_once(
            device, [&](gpu::Commands& commands) { commands.fill(made->from_, 0, moved_bytes); }));
        return std::unique_ptr<Mover>(std::move(made));
    }
    std::string name() const override { return "a copy out of the device's memory"; }
    Result<double> seconds(std::size_t bytes) override {
        const auto start = Clock::now();
        SEAWAY_TRY(commands_.begin());
        commands_.copy(from_, by_, bytes);
        commands_.barrier(gpu::Stage::copy, gpu::Stage::host);
        SEAWAY_TRY(commands_.end());
        SEAWAY_TRY(device_->submit_and_wait(commands_));
        std::memcpy(to_.data(), by_.mapped().data(), bytes);
        return seconds_since(start);
    }

  private:
    Readbacks() = default;
    std::unique_ptr<gpu::Device> device_;
    gpu::Buffer from_, by_;
    gpu::Commands commands_;
    std::vector<char> to_ = std::vector<char>(moved_bytes);
};

} // namespace

std::unique_ptr<Mover> native_mover() {
    return std::make_unique<Stores>();
}

Result<std::unique_ptr<Mover>> device_mover(const std::string& pick) {
    return Copies::create(pick);
}

Result<std::unique_ptr<Mover>> readback_mover(const std::string& pick) {
    return Readbacks::create(pick);
}

} // namespace seaway::bench
