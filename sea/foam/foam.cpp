// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam.h"

#include <algorithm>
#include <limits>

#include "base/check.h"
#include "sea/foam/foam_kernel.h"

namespace seaway::sea {

const FoamKernel& foam_kernel(Instructions instructions) {
#if defined(SEAWAY_X86)
    if (instructions == Instructions::avx512)
        return foam_kernel_avx512();
    if (instructions == Instructions::avx2)
        return foam_kernel_avx2();
#else
    SEAWAY_CHECK(instructions == Instructions::portable, "no other kernel is built");
#endif
    return foam_kernel_portable();
}

double foam_coverage(double mean, std::span<const float> ratios) {
    double together = 2.0;
    for (const float ratio : ratios)
        together *= 0.5 * (1.0 + static_cast<double>(ratio));
    return std::clamp(mean * (together - 1.0), 0.0, 1.0);
}

// ---- a map -----------------------------------------------------------------------------------

FoamRatios::FoamRatios(int size, Instructions instructions)
    : kernel_(&foam_kernel(instructions)),
      values_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 1.0f) {}

void FoamRatios::advance(const FoamTick& tick, const Keyframe* strains, std::span<float> values,
                         std::size_t first) const {
    if (!tick.looks()) {
        for (float& ratio : values)
            ratio = ratio * tick.remains + tick.added;
        return;
    }
    SEAWAY_CHECK(strains != nullptr && strains->fields.contains(foam_inputs) &&
                     strains->plane_size() == values_.size(),
                 "foam needs the strains of its cascade");
    kernel_->advance(tick, strains->plane(Field::strain_xx).data() + first,
                     strains->plane(Field::strain_yy).data() + first,
                     strains->plane(Field::strain_xy).data() + first, values.data(), values.size());
}

int FoamRatios::parts() const {
    return static_cast<int>((values_.size() + part_points - 1) / part_points);
}

FoamRatios::Part FoamRatios::part(int n) const {
    const std::size_t first = static_cast<std::size_t>(n) * part_points;
    return {first, std::min(values_.size() - first, std::size_t{part_points})};
}

void FoamRatios::take(const FoamTick& tick, const Keyframe* strains) {
    take(tick, strains, {0, values_.size()});
}

void FoamRatios::take(const FoamTick& tick, const Keyframe* strains, Part part) {
    advance(tick, strains, std::span(values_).subspan(part.first, part.count), part.first);
}

void FoamRatios::show(const FoamView& view, const Keyframe* strains, std::span<float> plane) const {
    show(view, strains, plane, {0, values_.size()});
}

void FoamRatios::show(const FoamView& view, const Keyframe* strains, std::span<float> plane,
                      Part part) const {
    SEAWAY_CHECK(plane.size() == values_.size(), "a foam map has the size of its cascade");
    const std::span<const float> from = values().subspan(part.first, part.count);
    const std::span<float> shown = plane.subspan(part.first, part.count);
    std::copy(from.begin(), from.end(), shown.begin());
    if (view.is_state())
        return;
    advance(view.tick, strains, shown, part.first);
    if (view.departure != 1.0f)
        for (float& ratio : shown)
            ratio = 1.0f + view.departure * (ratio - 1.0f);
}

// ---- a history -------------------------------------------------------------------------------

FoamHistory::FoamHistory(FoamLawPtr law, int cascade, int size, TimeUs interval_us,
                         Instructions instructions)
    : cascade_(cascade), walk_(std::move(law), cascade, interval_us), state_(size, instructions) {}

void FoamHistory::advance(const Keyframe& strains, double dt_s) {
    SEAWAY_CHECK(dt_s >= 0, "foam does not run backwards");
    walk_.restart(); // on no tick
    shown_.clear();
    const FoamLaw& law = walk_.law();
    if (!foam_idle(law, cascade_))
        state_.take(foam_tick(law, cascade_, foam_remains(dt_s, law.model.decay_s)), &strains);
}

Result<KeyframePtr> FoamHistory::strains(const FoamTick& tick, TimeUs time_us,
                                         const StrainsAt& strains_at) {
    if (!tick.looks())
        return KeyframePtr();
    Result<KeyframePtr> made = strains_at(time_us);
    SEAWAY_CHECK(!made || (*made)->cascade == cascade_, "foam needs the strains of its cascade");
    return made;
}

Result<bool> FoamHistory::walk_towards(TimeUs time_us, int ticks_max, const StrainsAt& strains_at) {
    SEAWAY_CHECK(ticks_max >= 1, "every slice goes some way");
    for (int walked = 0; walked < ticks_max; ++walked) {
        const std::optional<FoamStep> step = walk_.next(time_us);
        if (!step)
            return true;
        const Result<KeyframePtr> there = strains(step->tick, step->time_us, strains_at);
        if (!there) {
            walk_.restart(); // the next call starts anew
            return there.error();
        }
        state_.take(step->tick, there->get());
    }
    return walk_.ticks_to(time_us) == 0;
}

Result<void> FoamHistory::advance_to(TimeUs time_us, const StrainsAt& strains_at) {
    SEAWAY_TRY(walk_towards(time_us, std::numeric_limits<int>::max(), strains_at));
    shown_.clear();
    const FoamView view = walk_.at(time_us);
    if (view.is_state())
        return {};
    const Result<KeyframePtr> there = strains(view.tick, time_us, strains_at);
    if (!there)
        return there.error();
    std::vector<float> shown(state_.values().size());
    state_.show(view, there->get(), shown);
    shown_ = std::move(shown);
    return {};
}

void FoamHistory::fill(std::span<float> plane) const {
    const std::span<const float> shown = ratios();
    SEAWAY_CHECK(plane.size() == shown.size(), "a foam map has the size of its cascade");
    std::copy(shown.begin(), shown.end(), plane.begin());
}

} // namespace seaway::sea
