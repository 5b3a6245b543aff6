// SPDX-License-Identifier: Apache-2.0
// World: whose waves a session is sent, and who pays for what is made of them.
#include <algorithm>

#include "protocol/limits.h"
#include "server/process_metrics.h"
#include "server/world.h"

namespace seaway::server {

SpectrumSource World::source_of(const RunningSea& sea) const {
    // A change is a glide and the sea that it leads to, the next epoch.
    return {sea.epoch,
            sea.realization,
            sea.scene.sea.dispersion(),
            sea.budget.height_error_m,
            course_->ends_a_glide(sea.epoch) ? sea.epoch - 1 : 0,
            sea.glide ? sea.glide->change.end_us() : course_->window(sea.epoch).start_us};
}

std::vector<SpectrumSource> World::origins_of(std::uint32_t epoch) const {
    std::vector<SpectrumSource> held;
    {
        const std::scoped_lock lock(mutex_);
        held = origins_;
    }
    std::vector<std::uint32_t> epochs = course_->origins(epoch);
    std::ranges::reverse(epochs); // the first one first: each is made of the one before
    std::vector<SpectrumSource> origins;
    for (const std::uint32_t origin : epochs) {
        const auto found = std::ranges::find(held, origin, &SpectrumSource::epoch);
        origins.push_back(found != held.end() ? *found : source_of(*course_->sea(origin)));
        (void)sea_state_message(origin); // goes to who is sent the waves
    }
    std::ranges::reverse(origins);
    return origins;
}

std::vector<SpectrumSource> World::spectrum_sources(const SpectrumRequest& request) const {
    const RunningSeaPtr running = sea_now();
    std::vector<SpectrumSource> sources{source_of(*running)};
    {
        const std::scoped_lock lock(mutex_);
        sources.insert(sources.end(), origins_.begin(), origins_.end());
        for (const RunningSeaPtr& sea : told_)
            if (sea != running)
                sources.push_back(source_of(*sea));
    }
    const auto comes = [&](std::uint32_t epoch) {
        return std::ranges::find(sources, epoch, &SpectrumSource::epoch) != sources.end();
    };
    const auto has = [&](std::uint32_t epoch) {
        return std::ranges::find(request.has, epoch) != request.has.end();
    };
    std::vector<SpectrumSource> wanted;
    for (const SpectrumSource& sea : sources)
        if (!has(sea.epoch) &&
            (sea.ends_epoch == 0 || (!has(sea.ends_epoch) && !comes(sea.ends_epoch))))
            wanted.push_back(sea);
    if (wanted.size() > protocol::limits::spectra_max)
        wanted.resize(protocol::limits::spectra_max);
    return wanted;
}

Result<GrantedSpectrum> World::spectrum(const SpectrumRequest& request) {
    if (request.asker.gone())
        return Error{Refusal::gone, "who asked has gone"};
    const std::vector<SpectrumSource> seas = spectrum_sources(request);
    if (seas.empty())
        return GrantedSpectrum{};
    const double price_us =
        request.asked ? price_spectrum_wave_us *
                            static_cast<double>(spectra_.points_to_make(seas, request.wish))
                      : 0;
    if (price_us == 0)
        return spectra_.grant(seas, request.wish);
    SEAWAY_TRY(simulation_->charge(request.asker, price_us));
    const double start_s = steady_seconds();
    Result<GrantedSpectrum> granted = spectra_.grant(seas, request.wish);
    simulation_->settle(request.asker, price_us - 1e6 * (steady_seconds() - start_s));
    return granted;
}

std::optional<GrantedSpectrum> World::held_spectrum(const SpectrumRequest& request) {
    const std::vector<SpectrumSource> seas = spectrum_sources(request);
    return seas.empty() ? GrantedSpectrum{} : spectra_.held(seas, request.wish);
}

} // namespace seaway::server
