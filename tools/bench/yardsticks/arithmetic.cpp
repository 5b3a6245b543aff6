// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/yardsticks/arithmetic.h"

#include <atomic>
#include <chrono>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/instructions.h"
#include "base/thread_pool.h"
#include "gpu/commands.h"
#include "gpu/device.h"
#include "gpu/kernel.h"
#include "shaders/shared/synthesis.h"
#include "shaders/synthesis.h"
#include "tools/bench/yardsticks/sums.h"

namespace seaway::bench {

namespace {

using Clock = std::chrono::steady_clock;

/// Long enough that neither a submission nor a thread that wakes counts.
constexpr double enough_s = 0.01;
constexpr std::uint32_t rounds_max = 1u << 22;

/// Rounds are doubled until they take long enough.
template <class Run>
Result<double> rate_of(std::uint32_t& rounds, double operations_a_round, const Run& run) {
    while (true) {
        const auto start = Clock::now();
        SEAWAY_TRY(run(rounds));
        const double seconds = seconds_since(start);
        if (seconds >= enough_s || rounds >= rounds_max)
            return operations_a_round * rounds / seconds;
        rounds *= 2;
    }
}

class OnDevice final : public Arithmetic {
  public:
    static Result<std::unique_ptr<Arithmetic>> create(const std::string& pick) {
        std::unique_ptr<OnDevice> made(new OnDevice);
        SEAWAY_TRY_LET(made->device_, gpu::Device::create({.pick = pick}));
        gpu::Device& device = *made->device_;
        SEAWAY_TRY_LET(
            made->kernel_,
            gpu::Kernel::create(device, shaders::peak().name, shaders::peak().spirv,
                                {.bindings = {{"Target", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}},
                                 .push_constant_bytes = sizeof(shaders::PeakPush),
                                 .local_size = {shaders::synthesis_workgroup, 1, 1}}));
        SEAWAY_TRY_LET(made->target_,
                       gpu::Buffer::create(device, "sums", std::size_t{16} * invocations,
                                           gpu::BufferKind::device));
        SEAWAY_TRY_LET(made->bindings_, made->kernel_.bind(device, {gpu::whole(made->target_)}));
        SEAWAY_TRY_LET(made->commands_, gpu::Commands::create(device));
        return std::unique_ptr<Arithmetic>(std::move(made));
    }
    std::string name() const override { return "a kernel of fused products and sums"; }
    bool rests() const override { return !device_->info().is_cpu(); }
    Result<double> operations_per_s() override {
        constexpr double a_round =
            2.0 * 4 * shaders::peak_chains * shaders::peak_steps * invocations;
        return rate_of(rounds_, a_round, [&](std::uint32_t rounds) -> Result<void> {
            const shaders::PeakPush push{rounds, 0.5f, 1.0f};
            SEAWAY_TRY(commands_.begin());
            commands_.dispatch(kernel_, bindings_, std::as_bytes(std::span(&push, 1)),
                               invocations / shaders::synthesis_workgroup);
            SEAWAY_TRY(commands_.end());
            return device_->submit_and_wait(commands_);
        });
    }

  private:
    static constexpr std::uint32_t invocations = 1u << 18;
    OnDevice() = default;
    std::unique_ptr<gpu::Device> device_;
    gpu::Kernel kernel_;
    gpu::Buffer target_;
    gpu::Bindings bindings_;
    gpu::Commands commands_;
    std::uint32_t rounds_ = 2;
};

const Sums& best_sums() {
    switch (best_instructions()) {
#ifdef SEAWAY_X86
    case Instructions::avx512:
        return sums_avx512();
    case Instructions::avx2:
        return sums_avx2();
#endif
    default:
        return sums_portable();
    }
}

class Here final : public Arithmetic {
  public:
    std::string name() const override {
        return fmt::format("products and sums of {} threads, {}", pool_.threads(),
                           seaway::name(best_instructions()));
    }
    bool rests() const override { return false; }
    Result<double> operations_per_s() override {
        const Sums& sums = best_sums();
        return rate_of(rounds_, static_cast<double>(sums.operations) * pool_.threads() * 1024,
                       [&](std::uint32_t rounds) -> Result<void> {
                           struct Work {
                               const Sums& sums;
                               std::size_t rounds;
                               std::atomic<float>& kept; ///< so that it is computed
                           };
                           const Work work{sums, std::size_t{rounds} * 1024, kept_};
                           const Phase phase{[](const void* context, int, int) {
                                                 const Work& own =
                                                     *static_cast<const Work*>(context);
                                                 own.kept = own.sums.run(own.rounds, 0.5f, 1.0f);
                                             },
                                             &work, pool_.threads()};
                           pool_.run({&phase, 1});
                           return {};
                       });
    }

  private:
    ThreadPool pool_;
    std::uint32_t rounds_ = 16;
    std::atomic<float> kept_ = 0;
};

} // namespace

Result<std::unique_ptr<Arithmetic>> device_arithmetic(const std::string& pick) {
    return OnDevice::create(pick);
}

std::unique_ptr<Arithmetic> native_arithmetic() {
    return std::make_unique<Here>();
}

} // namespace seaway::bench
