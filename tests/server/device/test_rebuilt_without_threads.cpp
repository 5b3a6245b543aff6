// SPDX-License-Identifier: Apache-2.0
// Devices whose threads the system does not give, as at a limit of processes: std::thread throws.
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <gtest/gtest.h>

#include "base/messages.h"
#include "server/device/rebuilt_synthesizer.h"

namespace seaway::server {
namespace {

/// Lost as soon as it is told so.
class LostAtWork final : public Synthesizer {
  public:
    explicit LostAtWork(bool& lost) : lost_(lost) {}
    std::string description() const override { return "lost at work"; }
    Result<void> set_sea(sea::RealizationPtr, std::uint32_t) override { return {}; }
    Result<FoamMapPtr> open_foam(int, const FoamMap*) override { return Error{"no foam here"}; }
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override {
        if (lost_)
            return Error{"lost at work"};
        return std::vector<NewKeyframePtr>(requests.size());
    }
    SynthesisCounters counters() const override { return {}; }

  private:
    bool& lost_;
};

struct FewThreads {
    int refused = 0;   ///< to so many of the devices that are made next
    bool lost = false; ///< the one that is there
    std::vector<std::string> warnings = {};

    Result<std::unique_ptr<RebuiltSynthesizer>> start() {
        return RebuiltSynthesizer::start(
            [this](const sea::RealizationPtr&, std::uint32_t,
                   Making) -> Result<std::unique_ptr<Synthesizer>> {
                if (refused > 0 && refused-- > 0)
                    throw std::system_error(
                        std::make_error_code(std::errc::resource_unavailable_try_again));
                lost = false;
                return std::unique_ptr<Synthesizer>(std::make_unique<LostAtWork>(lost));
            },
            nullptr, 1, [this](const std::string& why) { warnings.push_back(why); });
    }
};

// Naive: what a lost device had of threads is let go of, somebody else takes it, and the server aborts.
TEST(RebuiltWithoutThreads, a_thread_that_a_new_device_is_not_given_is_one_try_that_failed) {
    FewThreads threads;
    const std::unique_ptr<RebuiltSynthesizer> device = threads.start().value();
    const KeyframeRequest request{0, 1, {sea::Field::height}};
    threads.lost = true;
    threads.refused = 1;
    const auto made = device->synthesize({&request, 1});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(device->rebuilds(), 2u);
    ASSERT_EQ(threads.warnings.size(), 2u);
    EXPECT_NE(threads.warnings[1].find(no_further_thread), std::string::npos)
        << threads.warnings[1];
}

// What whoever starts says of it is another line, with another exit code.
TEST(RebuiltWithoutThreads, a_start_without_threads_is_told_by_whoever_starts) {
    FewThreads threads{.refused = 1};
    EXPECT_THROW((void)threads.start(), std::system_error);
    EXPECT_TRUE(threads.start());
}

} // namespace
} // namespace seaway::server
