// SPDX-License-Identifier: Apache-2.0
// Devices that fail as they are told to: how often another one is made, and when.
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/device/rebuilt_synthesizer.h"

namespace seaway::server {
namespace {

/// What devices are told, and what became of them.
struct Yard {
    int fails = 0;            ///< so many of those that are made next
    bool refuses_sea = false; ///< the one that is there
    bool fails_foam = false;  ///< all of them
    bool lacks_memory = false;
    bool fails_work = false; ///< all that are the first one's kind
    int made = 0;
    std::vector<Making> makings = {}; ///< as they were asked for
    std::vector<std::string> warnings = {};
};

struct MapOfOne final : FoamMap {
    explicit MapOfOne(std::shared_ptr<bool> there) : device_there(std::move(there)) {}
    bool lost() const override { return !*device_there; }
    const std::shared_ptr<bool> device_there;
};

class OneDevice final : public Synthesizer {
  public:
    explicit OneDevice(Yard& yard) : yard_(yard) {}
    ~OneDevice() override { *there_ = false; }
    std::string description() const override { return "one"; }
    Result<void> set_sea(sea::RealizationPtr, std::uint32_t) override {
        return yard_.refuses_sea ? Result<void>(Error{"lost"}) : Result<void>();
    }
    Result<FoamMapPtr> open_foam(int, const FoamMap*) override {
        return FoamMapPtr(std::make_shared<MapOfOne>(there_));
    }
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override {
        if (yard_.fails_work && yard_.makings.back() != Making::another)
            return Error{"lost at work"};
        if (yard_.lacks_memory)
            return Error{DeviceError::out_of_memory, "full"};
        if (yard_.fails_foam && requests[0].foam != nullptr)
            return Error{"lost in foam"};
        return std::vector<NewKeyframePtr>(requests.size());
    }
    SynthesisCounters counters() const override {
        return {.dispatches = 10, .device_seconds = 0.5};
    }

  private:
    Yard& yard_;
    const std::shared_ptr<bool> there_ = std::make_shared<bool>(true);
};

std::unique_ptr<RebuiltSynthesizer> started(Yard& yard) {
    return RebuiltSynthesizer::start(
               [&](const sea::RealizationPtr&, std::uint32_t,
                   server::Making making) -> Result<std::unique_ptr<Synthesizer>> {
                   yard.makings.push_back(making);
                   if (yard.fails > 0 && yard.fails-- > 0)
                       return Error{"no device now"};
                   ++yard.made;
                   return std::unique_ptr<Synthesizer>(std::make_unique<OneDevice>(yard));
               },
               nullptr, 1, [&](const std::string& why) { yard.warnings.push_back(why); })
        .value();
}

// Naive: three tries within 22 ms. A GPU whose driver is loaded anew is away for seconds, and the server has ended before.
TEST(RebuiltSynthesizer,
     what_is_away_for_a_while_is_waited_for_and_another_one_taken_at_last_alone) {
    Yard yard;
    const std::unique_ptr<RebuiltSynthesizer> device = started(yard);
    yard.refuses_sea = true;
    ASSERT_TRUE(device->set_sea(nullptr, 1));
    yard.refuses_sea = false;
    yard.fails = 2;
    const KeyframeRequest request{0, 1, {sea::Field::height}};
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_TRUE(device->synthesize({&request, 1}));
    EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::seconds(3));
    using enum Making;
    EXPECT_EQ(yard.makings, (std::vector{what_there_is, the_same, the_same, what_there_is}));
}

// Each device has counted as much. Naive: it is let go of before what it has counted is taken over.
TEST(RebuiltSynthesizer, counters_go_on_over_devices_that_were_lost) {
    Yard yard;
    const std::unique_ptr<RebuiltSynthesizer> device = started(yard);
    const KeyframeRequest request{0, 1, {sea::Field::height}};
    yard.fails_work = true;
    EXPECT_TRUE(device->synthesize({&request, 1})) << "by another one";
    EXPECT_EQ(yard.makings.back(), Making::another)
        << "the first kind was made each time, and failed";
    EXPECT_EQ(yard.made, 1 + device_rebuilds_max);
    EXPECT_EQ(device->counters().dispatches, 10u * (1 + device_rebuilds_max));
    EXPECT_EQ(device->counters().device_seconds, 0.5 * (1 + device_rebuilds_max));
}

// It is there, and so are others who ask for less; whoever runs it is told now and then, and not at each request.
TEST(RebuiltSynthesizer, a_device_without_memory_for_a_request_is_not_made_anew) {
    Yard yard;
    const std::unique_ptr<RebuiltSynthesizer> device = started(yard);
    const KeyframeRequest request{0, 1, {sea::Field::height}};
    for (int i = 0; i < 10; ++i) {
        yard.lacks_memory = i % 2 == 0;
        const auto made = device->synthesize({&request, 1});
        ASSERT_EQ(made.has_value(), i % 2 != 0);
        EXPECT_TRUE(made || made.error().is(DeviceError::out_of_memory));
    }
    EXPECT_EQ(yard.warnings.size(), 1u) << "in the first minute";
    EXPECT_EQ(device->rebuilds(), 0u);
    EXPECT_EQ(yard.made, 1);
}

// As in a glide: the sea is another at each moment.
TEST(RebuiltSynthesizer, a_device_that_a_new_sea_has_cost_is_made_anew_as_often_as_any) {
    Yard yard;
    const std::unique_ptr<RebuiltSynthesizer> device = started(yard);
    const FoamMapPtr map = device->open_foam(64, nullptr).value();
    yard.refuses_sea = true;
    ASSERT_TRUE(device->set_sea(nullptr, 1));
    yard.refuses_sea = false;
    const FoamTurn turn{map.get(), {}, {}};
    const KeyframeRequest of_foam{0, 0, {sea::Field::foam}, 1, &turn},
        of_height{0, 1, {sea::Field::height}};
    const auto lost = device->synthesize({&of_foam, 1});
    ASSERT_FALSE(lost);
    EXPECT_TRUE(lost.error().is(DeviceError::foam_lost));
    yard.fails = 2;
    ASSERT_TRUE(device->set_sea(nullptr, 1)) << "nothing was tried yet";
    EXPECT_EQ(device->rebuilds(), 0u);
    const auto made = device->synthesize({&of_height, 1});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(device->rebuilds(), 3u);
    EXPECT_EQ(yard.made, 2);
}

// Naive: a device is there again each time, so foam starts anew for ever, and nobody hears that it cannot be had.
TEST(RebuiltSynthesizer, devices_that_all_fail_on_foam_end_as_any_that_fails) {
    Yard yard;
    const std::unique_ptr<RebuiltSynthesizer> device = started(yard);
    const auto foam = [&] {
        const FoamMapPtr map = device->open_foam(64, nullptr).value();
        const FoamTurn turn{map.get(), {}, {}};
        const KeyframeRequest request{0, 0, {sea::Field::foam}, 1, &turn};
        return device->synthesize({&request, 1});
    };
    const KeyframeRequest of_height{0, 1, {sea::Field::height}};
    for (int round = 0; round < 2; ++round) {
        yard.fails_foam = true;
        for (int i = 0; i < device_rebuilds_max; ++i) {
            const auto lost = foam();
            ASSERT_FALSE(lost);
            EXPECT_TRUE(lost.error().is(DeviceError::foam_lost)) << i;
            EXPECT_TRUE(device->synthesize({&of_height, 1}));
        }
        EXPECT_EQ(yard.makings.back(), Making::another) << "the third was the last of its kind";
        if (round == 0) { // foam in between: they are counted anew
            yard.fails_foam = false;
            EXPECT_TRUE(foam());
        }
    }
    const auto last = foam();
    ASSERT_FALSE(last);
    EXPECT_FALSE(last.error().is(DeviceError::foam_lost));
    EXPECT_EQ(last.error().message, "lost in foam");
}

TEST(RebuiltSynthesizer, a_device_that_cannot_be_made_at_the_start_is_an_error_at_once) {
    Yard yard{.fails = 1};
    const auto device = RebuiltSynthesizer::start(
        [&](const sea::RealizationPtr&, std::uint32_t,
            server::Making) -> Result<std::unique_ptr<Synthesizer>> {
            ++yard.made;
            return Error{"none"};
        },
        nullptr, 1, {});
    EXPECT_FALSE(device);
    EXPECT_EQ(yard.made, 1);
}

} // namespace
} // namespace seaway::server
