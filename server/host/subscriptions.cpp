// SPDX-License-Identifier: Apache-2.0
#include "server/host/subscriptions.h"

#include <algorithm>
#include <utility>

namespace seaway::server {

void Subscriptions::set(SessionId session, const Demand& grant) {
    if (grant.empty())
        return erase(session);
    {
        Demand now = grant; // where there is no memory for it nothing has changed
        const std::scoped_lock lock(mutex_);
        const auto [at, is_new] = grants_.try_emplace(session);
        if (!is_new)
            --of_quality_[at->second.quality];
        ++of_quality_[now.quality];
        at->second = std::move(now);
    }
    if (changed_)
        changed_();
}

void Subscriptions::erase(SessionId session) {
    {
        const std::scoped_lock lock(mutex_);
        const auto at = grants_.find(session);
        if (at == grants_.end())
            return;
        --of_quality_[at->second.quality];
        grants_.erase(at);
    }
    if (changed_)
        changed_();
}

std::optional<Demand> Subscriptions::find(SessionId session) const {
    const std::scoped_lock lock(mutex_);
    const auto found = grants_.find(session);
    return found == grants_.end() ? std::nullopt : std::optional(found->second);
}

std::size_t Subscriptions::size() const {
    const std::scoped_lock lock(mutex_);
    return grants_.size();
}

template <class Includes>
sea::FieldSet Subscriptions::union_of(const Includes& includes) const {
    const std::scoped_lock lock(mutex_);
    sea::FieldSet fields;
    for (const auto& [session, grant] : grants_)
        if (includes(grant))
            fields |= grant.fields;
    return fields;
}

sea::FieldSet Subscriptions::wanted(int cascade) const {
    return union_of([&](const Demand& grant) { return grant.wants(cascade); });
}

sea::FieldSet Subscriptions::wanted(int cascade, Quality quality, sea::FieldSet may_follow) const {
    const std::scoped_lock lock(mutex_);
    sea::FieldSet fields;
    for (const auto& [session, grant] : grants_)
        if (grant.quality == quality && grant.wants(cascade))
            fields |= grant.fields.without(may_follow & sea::following(grant.fields));
    return fields;
}

std::array<sea::FieldSet, rate_rungs_hz.size()> Subscriptions::wanted_by_rate(int cascade) const {
    const std::scoped_lock lock(mutex_);
    std::array<sea::FieldSet, rate_rungs_hz.size()> fields{};
    for (const auto& [session, grant] : grants_)
        if (grant.wants(cascade))
            fields[rung_of(grant.quality).rate] |= grant.fields;
    return fields;
}

std::vector<Quality> Subscriptions::most_wanted(int cascade, std::uint64_t turn) const {
    std::array<std::size_t, quality_rungs> readers{};
    {
        const std::scoped_lock lock(mutex_);
        for (const auto& [session, grant] : grants_)
            readers[grant.quality] += grant.wants(cascade) ? 1 : 0;
    }
    std::vector<Quality> used;
    for (Quality quality = 0; quality < quality_rungs; ++quality)
        if (readers[quality] > 0)
            used.push_back(quality);
    if (!used.empty())
        std::rotate(used.begin(), used.begin() + static_cast<std::ptrdiff_t>(turn % used.size()),
                    used.end());
    std::ranges::stable_sort(used, std::greater{},
                             [&](Quality quality) { return readers[quality]; });
    return used;
}

std::bitset<quality_rungs> Subscriptions::qualities_but(std::optional<SessionId> session) const {
    const std::scoped_lock lock(mutex_);
    const auto own = session ? grants_.find(*session) : grants_.end();
    std::bitset<quality_rungs> used;
    for (std::size_t quality = 0; quality < used.size(); ++quality)
        used[quality] = of_quality_[quality] >
                        (own != grants_.end() && own->second.quality == quality ? 1u : 0u);
    return used;
}

sea::FieldSet Subscriptions::wanted_without(int cascade, sea::Field field) const {
    return union_of(
        [&](const Demand& grant) { return grant.wants(cascade) && !grant.fields.contains(field); });
}

} // namespace seaway::server
