// SPDX-License-Identifier: Apache-2.0
#include "client/wave_prices.h"

#include <algorithm>

namespace seaway::client {

namespace {

/// Laying out fewer waves tells more of the clock than of the machine.
constexpr double lay_out_told_us = 5;

/// What something is expected to take once it has taken this.
double learnt(double expected, double took) {
    return 0.75 * expected + 0.25 * std::clamp(took, expected / 4, expected * 4);
}

double stylised_wave_us(const sea::SineField& field) {
    return (field.kind == sea::SineKind::exponential || !field.octaves.empty()) ? map_shaped_wave_us
                                                                                : map_plane_wave_us;
}

} // namespace

WavePrices::WavePrices(const SeaState& state, const OwnSea& waves) {
    const bool glides = waves.change() != nullptr;
    const sea::RealizationPtr sea =
        glides ? waves.change()->after() : waves.waves_at(state.start_time_us);
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        const sea::CascadeModes& modes = sea->cascades[c];
        const auto count = static_cast<double>(
            std::ranges::count_if(modes.h0, [](const auto& h0) { return h0 != 0.0; }));
        double stylised_us = 0;
        for (const sea::SineField& field : modes.sines)
            stylised_us += static_cast<double>(field.waves.size() + field.octaves.size()) *
                           stylised_wave_us(field);
        const double map_us = (glides ? gliding_map_point_us : map_point_us) + stylised_us;
        cascades_.push_back(
            {.interval_us = static_cast<double>(state.cascades[c].interval_us),
             .sum_point_us = count * sum_wave_us + stylised_us,
             .lay_out_us = (glides ? 2 : 1) * count * sum_wave_time_us, // what it grows by, too
             .sum_time_us = count * (glides ? gliding_wave_time_us : sum_wave_time_us),
             .keyframe_us = map_us * modes.spec.size * modes.spec.size});
    }
}

double WavePrices::expected_us(const Cascade& cascade) const {
    return cascade.keyframe_us * cascade.keyframe_takes * machine_takes_;
}

double WavePrices::keyframe_us(int cascade) const {
    const std::scoped_lock lock(mutex_);
    return expected_us(cascades_[static_cast<std::size_t>(cascade)]);
}

double WavePrices::listed_lay_out_us(std::uint32_t cascades) const {
    double us = 0;
    for (std::size_t c = 0; c < cascades_.size(); ++c)
        us += cascades >> c & 1u ? cascades_[c].lay_out_us : 0;
    return us;
}

double WavePrices::listed_point_us(std::uint32_t cascades) const {
    double us = 0;
    for (std::size_t c = 0; c < cascades_.size(); ++c)
        us += cascades >> c & 1u ? cascades_[c].sum_point_us : 0;
    return us;
}

double WavePrices::listed_sum_us(const WaveBatch& batch) const {
    double time_us = 0;
    for (std::size_t c = 0; c < cascades_.size(); ++c)
        time_us += batch.cascades >> c & 1u ? cascades_[c].sum_time_us : 0;
    return listed_point_us(batch.cascades) * static_cast<double>(batch.points) +
           time_us * static_cast<double>(batch.times);
}

double WavePrices::sum_us(const WaveBatch& batch) const {
    const std::scoped_lock lock(mutex_);
    return sums_take_ * listed_sum_us(batch);
}

void WavePrices::made(int cascade, double took_us) {
    const std::scoped_lock lock(mutex_);
    Cascade& made = cascades_[static_cast<std::size_t>(cascade)];
    made.keyframe_takes =
        learnt(made.keyframe_takes, took_us / (made.keyframe_us * machine_takes_));
}

void WavePrices::summed(const TimeSpan& cell, const WaveBatch& batch, double took_us,
                        double laid_out_us) {
    const std::scoped_lock lock(mutex_);
    if (const double listed_us = listed_lay_out_us(batch.cascades);
        laid_out_us > 0 && listed_us > lay_out_told_us)
        machine_takes_ = learnt(machine_takes_, laid_out_us / listed_us);
    account_of(cell, batch.cascades).sums_us += took_us;
    if (const double listed_us = listed_sum_us(batch); listed_us > 0)
        sums_take_ = std::max(learnt(sums_take_, took_us / listed_us), sums_take_min);
}

void WavePrices::spared(const TimeSpan& cell, const WaveBatch& batch) {
    const std::scoped_lock lock(mutex_);
    account_of(cell, batch.cascades).sums_us += sums_take_ * listed_sum_us(batch);
}

bool WavePrices::pays(const TimeSpan& cell, const WaveBatch& batch, double keyframes_us) {
    const std::scoped_lock lock(mutex_);
    if (listed_point_us(batch.cascades) < sampled_point_us)
        return false;
    const Account& account = account_of(cell, batch.cascades);
    return account.credit_us + account.sums_us + sums_take_ * listed_sum_us(batch) >=
           account.spent_us + keyframes_us;
}

void WavePrices::spend(const TimeSpan& cell, double keyframes_us) {
    const std::scoped_lock lock(mutex_);
    account_of(cell, 0).spent_us += keyframes_us;
}

double WavePrices::credit_left_us(const Account& account) const {
    const auto lasts_us = static_cast<double>(account.cell.until_us - account.cell.from_us);
    double steady_us = 0, all_us = 0;
    for (std::size_t c = 0; c < cascades_.size(); ++c)
        if (account.cascades >> c & 1u) {
            steady_us += expected_us(cascades_[c]) * lasts_us / cascades_[c].interval_us;
            all_us += 2 * expected_us(cascades_[c]);
        }
    const double left_us =
        account.credit_us + account.sums_us - std::max(account.spent_us, steady_us);
    return std::clamp(left_us, 0.0, all_us);
}

WavePrices::Account& WavePrices::account_of(const TimeSpan& cell, std::uint32_t cascades) {
    const auto is_same = [&](const Account& account) {
        return account.cell.from_us == cell.from_us && account.cell.until_us == cell.until_us;
    };
    auto found = std::ranges::find_if(accounts_, is_same);
    if (found == accounts_.end()) {
        double credit_us = 0;
        for (Account& account : accounts_)
            if (account.cell.until_us == cell.from_us || account.cell.from_us == cell.until_us) {
                credit_us += credit_left_us(account);
                account.credit_us = account.sums_us = account.spent_us = 0;
            }
        found = std::ranges::min_element(accounts_, {}, &Account::last_used);
        *found = {.cell = cell, .credit_us = credit_us};
    }
    found->cascades |= cascades;
    found->last_used = ++uses_;
    return *found;
}

} // namespace seaway::client
