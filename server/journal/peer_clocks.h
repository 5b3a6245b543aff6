// SPDX-License-Identifier: Apache-2.0
// PeerClocks: how far this server's sea is from those of its peers. Once a second each tells all others its sea time, and says back to some when
// it heard their last word and how long ago: a question and its answer, which the filter of a client's clock takes
// (base/clock_filter.h).
//
// Each answers the eight that are next to it in the ring of all names, four to either side, or all that there are: who
// answers is answered, each second, as the filter needs it, and names, which are drawn by lot, have nothing to do with places. A fleet of n
// takes n^2 words a second in any case; so a word does not grow with n as well.
//
// Judged by the middle of those that answer, this one included: of three servers the one whose clock is off sees two that agree.
// With two nobody can tell which is off.
//
// How long words take and are held is measured by the machines' clocks (base/local_clock.h): seas that are pulled towards a corrected UTC run
// apart meanwhile.
//
// Pure: times are given in, by that clock and since the sea's epoch (SeaClock). Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "base/clock_filter.h"

namespace seaway::server {

struct PeersSeen {
    int peers = 0;  ///< that have answered within heard_us
    int judges = 0; ///< of them, within judges_us
    double ahead_us =
        0; ///< this clock, of the middle one of these and this one, as they were last heard
    double error_us =
        0; ///< bound on that, but while a machine's own clock is corrected: then by up to half a millisecond more
    bool can_judge() const { return judges >= 2; }
};

class PeerClocks {
  public:
    static constexpr std::int64_t every_us = 1'000'000;
    /// One that says nothing for so long has gone.
    static constexpr std::int64_t heard_us = 10'000'000;
    /// Whose word counts: two in a row that did not come are of a server that has ended. One that starts again has another name, and
    /// would have two voices.
    static constexpr std::int64_t judges_us = 2'500'000;
    /// That are heard. Beyond it who has been silent longest makes place, of those who never said back to us if there is one:
    /// each start of a server has a name of its own.
    static constexpr std::size_t peers_max = 1024;
    /// That are answered: half of them to either side.
    static constexpr std::size_t answered_max = 8;

    /// `name` is unlike that of any other process: letters and digits.
    explicit PeerClocks(std::string name) : name_(std::move(name)) {}

    /// What is to be told to all, at this local time, which is `sea_us` of the sea.
    std::string word(LocalUs local_us, std::int64_t sea_us);
    /// What another has told, when it was this time here. Text that is none is let be.
    void hear(const std::string& word, LocalUs local_us, std::int64_t sea_us);

    PeersSeen seen(LocalUs local_us) const;

  private:
    struct Peer {
        ClockFilter filter;                 ///< its local clock is this sea
        std::optional<LocalUs> answered_us; ///< when it last said back what it heard of us
        LocalUs heard_us = 0;               ///< its last word, by our clock
        std::int64_t sent_us = 0;           ///< and by its own
    };
    /// Does `with(name, peer)` for each that is to be answered. Under the lock.
    template <class With>
    void each_answered(const With& with) const;

    void make_place();

    const std::string name_;
    mutable std::mutex mutex_; ///< of what follows
    std::map<std::string, Peer> peers_;
};

} // namespace seaway::server
