// SPDX-License-Identifier: Apache-2.0
#include "server/device/rebuilt_synthesizer.h"

#include <algorithm>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "base/messages.h"

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
    let_go(); // as above
    return {};
}

void RebuiltSynthesizer::let_go() {
    before_ = counters();
    device_.reset();
}

Result<void> RebuiltSynthesizer::rebuild(Making making) {
    let_go();
    SEAWAY_TRY_LET(device_, factory_(sea_, epoch_, making));
    return {};
}

Result<void> RebuiltSynthesizer::try_again(int tries, bool failed_at_work) {
    ++rebuilds_;
    let_go(); // what it has is free meanwhile
    const int at = std::min(tries, device_rebuilds_max - 1);
    std::this_thread::sleep_for(device_rebuild_pauses[static_cast<std::size_t>(at)]);
    const bool last = at == device_rebuilds_max - 1;
    try {
        return rebuild(!last            ? Making::the_same
                       : failed_at_work ? Making::another
                                        : Making::what_there_is);
    } catch (const std::system_error& problem) { // nobody further up waits for it
        const bool threads = problem.code() == std::errc::resource_unavailable_try_again;
        return Error{threads ? std::string(no_further_thread) : std::string(problem.what())};
    }
}

void RebuiltSynthesizer::warn_of_memory(const Error& why) {
    ++refused_;
    const auto now = std::chrono::steady_clock::now();
    if (!warn_ || (warned_of_memory_ && now - *warned_of_memory_ < std::chrono::minutes(1)))
        return;
    warn_(fmt::format("refused for want of memory, {} times: {}", refused_, why.message));
    warned_of_memory_ = now;
    refused_ = 0;
}

template <class T, class Work>
Result<T> RebuiltSynthesizer::attempt(bool on_foam, const Work& work) {
    Error last{"there is no device"};
    bool failed_at_work = on_foam && foam_losses_ > 0;
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
            if (lacks_memory)
                warn_of_memory(made.error());
            if (made || lacks_memory)
                return made; // another device would have no more of it
            last = made.error();
            failed_at_work = failed_at_work || attempt > 0;
        }
        if (attempt == device_rebuilds_max)
            return last;
        if (warn_)
            warn_(fmt::format("device failed, rebuilding it ({} of {}): {}", attempt + 1,
                              device_rebuilds_max, last.message));
        const int tries = attempt + (on_foam ? foam_losses_ : 0);
        if (const Result<void> rebuilt = try_again(tries, failed_at_work); !rebuilt)
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
