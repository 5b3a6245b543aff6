// SPDX-License-Identifier: Apache-2.0
#include "client/wave_prices.h"

#include <algorithm>

namespace seaway::client {

namespace {

/// What something is expected to take once it has taken this. A thread that lost its processor in between moves it little.
double learnt(double expected, double took) {
    return 0.75 * expected + 0.25 * std::clamp(took, expected / 4, expected * 4);
}

double shaped_wave_us(const sea::SineField& field) {
    return (field.kind == sea::SineKind::exponential || !field.octaves.empty()) ? map_shaped_wave_us
                                                                                : map_plane_wave_us;
}

} // namespace

WavePrices::WavePrices(const SeaState& state, const OwnSea& waves)
    : wave_time_us_(waves.change() ? gliding_wave_time_us : sum_wave_time_us) {
    const sea::RealizationPtr sea =
        waves.change() ? waves.change()->after() : waves.waves_at(state.start_time_us);
    for (const sea::CascadeModes& modes : sea->cascades) {
        double point_us = waves.change() ? gliding_map_point_us : map_point_us;
        Cascade cascade{.waves = static_cast<double>(std::ranges::count_if(
                            modes.h0, [](const auto& h0) { return h0 != 0.0; }))};
        for (const sea::SineField& field : modes.sines) {
            const auto count = static_cast<double>(field.waves.size() + field.octaves.size());
            cascade.waves += count;
            point_us += count * shaped_wave_us(field);
        }
        cascade.keyframe_us = point_us * modes.spec.size * modes.spec.size;
        cascades_.push_back(cascade);
    }
}

double WavePrices::keyframe_us(int cascade) const {
    const std::scoped_lock lock(mutex_);
    return cascades_[static_cast<std::size_t>(cascade)].keyframe_us;
}

double WavePrices::listed_sum_us(const WaveBatch& batch) const {
    double waves = 0;
    for (std::size_t c = 0; c < cascades_.size(); ++c)
        waves += batch.cascades >> c & 1u ? cascades_[c].waves : 0;
    return waves * (sum_wave_us * static_cast<double>(batch.points) +
                    wave_time_us_ * static_cast<double>(batch.times));
}

double WavePrices::sum_us(const WaveBatch& batch) const {
    const std::scoped_lock lock(mutex_);
    return sums_take_ * listed_sum_us(batch);
}

void WavePrices::made(int cascade, double took_us) {
    const std::scoped_lock lock(mutex_);
    double& expected_us = cascades_[static_cast<std::size_t>(cascade)].keyframe_us;
    expected_us = learnt(expected_us, took_us);
}

void WavePrices::summed(const TimeSpan& cell, const WaveBatch& batch, double took_us) {
    const std::scoped_lock lock(mutex_);
    account_of(cell).paid_us += took_us;
    if (const double listed_us = listed_sum_us(batch); listed_us > 0)
        sums_take_ = learnt(sums_take_, took_us / listed_us);
}

bool WavePrices::pay(const TimeSpan& cell, const WaveBatch& batch, double keyframes_us) {
    const std::scoped_lock lock(mutex_);
    Account& account = account_of(cell);
    if (account.paid_us + sums_take_ * listed_sum_us(batch) < keyframes_us)
        return false;
    account.paid_us = 0;
    return true;
}

WavePrices::Account& WavePrices::account_of(const TimeSpan& cell) {
    const auto is_same = [&](const Account& account) {
        return account.cell.from_us == cell.from_us && account.cell.until_us == cell.until_us;
    };
    auto found = std::ranges::find_if(accounts_, is_same);
    if (found == accounts_.end()) {
        double left_us = 0;
        for (Account& account : accounts_)
            if (account.cell.until_us == cell.from_us || account.cell.from_us == cell.until_us)
                left_us += std::exchange(account.paid_us, 0.0);
        found = std::ranges::min_element(accounts_, {}, &Account::last_used);
        *found = {.cell = cell, .paid_us = left_us};
    }
    found->last_used = ++uses_;
    return *found;
}

} // namespace seaway::client
