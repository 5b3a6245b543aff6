// SPDX-License-Identifier: Apache-2.0
#include "server/journal/peer_clocks.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace seaway::server {
namespace {

constexpr const char* clock_magic = "seaway-clock-1";
/// Two machines differ by less, as a part of one, about how long a word was held; and while one of them corrects its clock.
constexpr double quartz_apart = 2e-4, corrected_apart = 1.2e-3;
/// Of an older server, which answers as many as it hears, up to 64.
constexpr std::size_t word_bytes_max = 16 * 1024;

bool is_name(const std::string& text) {
    return !text.empty() && text.size() <= 64 &&
           std::ranges::all_of(text, [](unsigned char c) { return std::isalnum(c) != 0; });
}

/// Some thirty thousand years: the difference of two fits.
bool is_time(std::int64_t us) {
    return us >= -1'000'000'000'000'000'000 && us <= 1'000'000'000'000'000'000;
}

double middle_of(std::vector<double>& values) {
    std::ranges::sort(values);
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

} // namespace

template <class With>
void PeerClocks::each_answered(const With& with) const {
    if (peers_.size() <= answered_max) {
        for (const auto& [name, peer] : peers_)
            with(name, peer);
        return;
    }
    auto after = peers_.upper_bound(name_), before = after;
    for (std::size_t i = 0; i < answered_max / 2; ++i) {
        if (after == peers_.end())
            after = peers_.begin();
        with(after->first, after->second);
        ++after;
        if (before == peers_.begin())
            before = peers_.end();
        --before;
        with(before->first, before->second);
    }
}

std::string PeerClocks::word(LocalUs local_us, std::int64_t sea_us) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(peers_, [local_us](const auto& peer) {
        return local_us - peer.second.heard_us > heard_us;
    });
    std::string text = fmt::format("{} {} {} {}\n", clock_magic, name_, local_us, sea_us);
    each_answered([&](const std::string& name, const Peer& peer) {
        text += fmt::format("{} {} {}\n", name, peer.sent_us, local_us - peer.heard_us);
    });
    return text;
}

void PeerClocks::hear(const std::string& word, LocalUs local_us, std::int64_t here_us) {
    std::istringstream in(word);
    std::string first, name;
    std::int64_t sent_us = 0, sea_us = 0;
    if (word.size() > word_bytes_max || !(in >> first >> name >> sent_us >> sea_us) ||
        first != clock_magic || !is_name(name) || name == name_ || !is_time(sea_us))
        return;
    const std::scoped_lock lock(mutex_);
    if (peers_.size() >= peers_max && !peers_.contains(name))
        make_place();
    Peer& peer = peers_[name];
    peer.heard_us = local_us;
    peer.sent_us = sent_us;
    std::string to;
    std::int64_t ours_us = 0, held_us = 0;
    while (in >> to >> ours_us >> held_us) {
        if (to != name_)
            continue;
        if (held_us >= 0 && held_us <= heard_us && ours_us <= local_us &&
            ours_us >= local_us - heard_us) {
            const std::int64_t unsure_us =
                1 + std::llround(quartz_apart * static_cast<double>(held_us));
            const std::int64_t round_trip_us = local_us - ours_us - held_us;
            // Held for longer than it was away.
            if (static_cast<double>(round_trip_us) <
                -1 - corrected_apart * static_cast<double>(held_us))
                return;
            peer.filter.add(here_us - std::max<std::int64_t>(round_trip_us, 0) - unsure_us, here_us,
                            sea_us);
            peer.answered_us = local_us;
        }
        return; // one answer a word
    }
}

void PeerClocks::make_place() {
    const auto counts_less = [](const auto& a, const auto& b) {
        return std::pair(a.second.answered_us.has_value(), a.second.heard_us) <
               std::pair(b.second.answered_us.has_value(), b.second.heard_us);
    };
    peers_.erase(std::ranges::min_element(peers_, counts_less));
}

PeersSeen PeerClocks::seen(LocalUs local_us) const {
    // Places of all clocks relative to this one, and how far they may be to either side of that.
    std::vector<double> places{0}, least{0}, most{0};
    int peers = 0;
    {
        const std::scoped_lock lock(mutex_);
        for (const auto& [name, peer] : peers_) {
            if (!peer.answered_us || local_us - *peer.answered_us > heard_us)
                continue;
            ++peers;
            if (local_us - *peer.answered_us > judges_us)
                continue;
            // Not as of now: what each may have run off since grows until its next word, and with it what is certain would come and go.
            const ClockStatus status = peer.filter.status(peer.filter.looked_us());
            places.push_back(status.offset_us);
            least.push_back(status.offset_us - status.error_us);
            most.push_back(status.offset_us + status.error_us);
        }
    }
    const double middle = middle_of(places);
    // The middle of all lies between the middles of what each can be.
    return {peers, static_cast<int>(places.size()) - 1, -middle,
            std::max(middle_of(most) - middle, middle - middle_of(least))};
}

} // namespace seaway::server
