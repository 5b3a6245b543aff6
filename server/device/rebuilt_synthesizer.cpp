// SPDX-License-Identifier: Apache-2.0
#include "server/device/rebuilt_synthesizer.h"

#include <algorithm>
#include <thread>

#include <fmt/format.h>

namespace seaway::server {

Result<std::unique_ptr<RebuiltSynthesizer>> RebuiltSynthesizer::start(SynthesizerFactory factory,
                                                                      sea::RealizationPtr sea,
                                                                      std::uint32_t epoch,
                                                                      Warn warn) {
    std::unique_ptr<RebuiltSynthesizer> made(
        new RebuiltSynthesizer(std::move(factory), std::move(warn)));
    SEAWAY_TRY(made->set_sea(std::move(sea), epoch));
    SEAWAY_TRY(made->rebuild(Making::what_there_is));
    return made;
}

std::string RebuiltSynthesizer::description() const {
    return device_ ? device_->description() : "none";
}

Result<void> RebuiltSynthesizer::set_sea(sea::RealizationPtr sea, std::uint32_t epoch) {
    sea_ = std::move(sea);
    epoch_ = epoch;
    if (!device_) // what is asked for next makes one, with this sea
        return {};
    const Result<void> taken = device_->set_sea(sea_, epoch_);
    if (taken || taken.error().is(DeviceError::cannot_do_this_sea))
        return taken;
    if (warn_)
        warn_(fmt::format("device failed on a new sea, it will be rebuilt: {}",
                          taken.error().message));
    before_ = counters();
    device_.reset(); // as above
    return {};
}

Result<void> RebuiltSynthesizer::rebuild(Making making) {
    before_ = counters();
    device_.reset();
    SEAWAY_TRY_LET(device_, factory_(sea_, epoch_, making));
    return {};
}

template <class T, class Work>
Result<T> RebuiltSynthesizer::attempt(bool on_foam, const Work& work) {
    Error last{"there is no device"};
    for (int attempt = 0;; ++attempt) {
        if (device_ && attempt > 0 && on_foam) {
            // Who starts foam anew and fails each time has a device that cannot do it.
            if (++foam_losses_ > device_rebuilds_max)
                return last;
            return Error{DeviceError::foam_lost, last.message};
        }
        if (device_) {
            Result<T> made = work(*device_);
            const bool lacks_memory = !made && made.error().is(DeviceError::out_of_memory);
            if (warn_ && lacks_memory && !lacks_memory_)
                warn_("refused for want of memory: " + made.error().message);
            lacks_memory_ = lacks_memory;
            if (made || lacks_memory)
                return made; // another device would have no more of it
            last = made.error();
        }
        if (attempt == device_rebuilds_max)
            return last;
        if (warn_)
            warn_(fmt::format("device failed, rebuilding it ({} of {}): {}", attempt + 1,
                              device_rebuilds_max, last.message));
        ++rebuilds_;
        device_.reset(); // what it has is free meanwhile
        std::this_thread::sleep_for(device_rebuild_pauses[static_cast<std::size_t>(attempt)]);
        const bool no_other_follows = attempt + 1 == device_rebuilds_max;
        if (const Result<void> rebuilt =
                rebuild(no_other_follows ? Making::what_there_is : Making::the_same);
            !rebuilt)
            last = rebuilt.error();
    }
}

Result<FoamMapPtr> RebuiltSynthesizer::open_foam(int size, const FoamMap* from) {
    return attempt<FoamMapPtr>(from != nullptr,
                               [&](Synthesizer& device) { return device.open_foam(size, from); });
}

Result<std::vector<NewKeyframePtr>>
RebuiltSynthesizer::synthesize(std::span<const KeyframeRequest> requests) {
    const bool on_foam =
        std::ranges::any_of(requests, [](const auto& request) { return request.foam != nullptr; });
    // A device that was made anew while maps were opened has none of those before.
    if (std::ranges::any_of(requests, [](const KeyframeRequest& request) {
            return request.foam != nullptr && request.foam->map->lost();
        }))
        return Error{DeviceError::foam_lost, "the device that a foam map stood on was lost"};
    Result<std::vector<NewKeyframePtr>> made = attempt<std::vector<NewKeyframePtr>>(
        on_foam, [&](Synthesizer& device) { return device.synthesize(requests); });
    if (made && on_foam)
        foam_losses_ = 0;
    return made;
}

SynthesisCounters RebuiltSynthesizer::counters() const {
    return device_ ? before_ + device_->counters() : before_;
}

} // namespace seaway::server
