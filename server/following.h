// SPDX-License-Identifier: Apache-2.0
// How a server stands with the log that its sea is a function of, and what it says of that. Values; thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "server/journal/journal.h"

namespace seaway::server {

/// Changes of others may wait so long to be played: they begin a second after they have to be known.
inline constexpr std::int64_t behind_us_max = 1'000'000;
/// And one of its own may be under way to the journal: it begins a second after sessions have to be told of it.
inline constexpr std::int64_t writing_us_max = 1'000'000;

/// And its sea may be so far ahead of its paces: 6 mm of a gale's height.
inline constexpr std::int64_t ahead_us_max = 1'000;

/// Why a server may not have the sea of the others.
enum class Doubt {
    none,
    stuck,   ///< what the log holds next cannot be played
    unheard, ///< the log has not been heard of; passes with that
    clock,   ///< its clock is off from those of the others
    ahead, ///< it ran on when the others had another pace already, and stands until they have come there; passes with that
    writing, ///< one of its own has been under way to the journal for so long that others should have been told; passes with that
    behind,  ///< some changes are not played yet; passes with that
};

/// The same in general words, for anybody: no name, number or word of another program. Empty: none.
std::string in_general(Doubt doubt);

struct Following {
    std::string name; ///< of the journal
    JournalStanding journal;
    bool shared = false;        ///< others append to it
    std::uint32_t played = 1;   ///< changes
    std::size_t counted = 1;    ///< with the rows of timetables, of changes_max
    std::int64_t behind_us = 0; ///< for how long there have been some to play
    std::int64_t writing_us =
        0; ///< for how long a change of its own has been under way to the journal
    std::int64_t ahead_us = 0; ///< its sea time, of what the paces say
    bool late = false;         ///< one of those has begun, or does so within behind_us_max
    double height_error_m = 0; ///< of the sea that runs: its budget
    double vertical_mps = 0; ///< and five standard deviations of its vertical velocity, at its pace
    std::string stuck;       ///< why the next one cannot be

    /// A clock that is off by this moves heights by their budget.
    double clock_budget_us() const;
    Doubt kind_of_doubt() const;
    /// Why this sea may not be that of the other servers, one line; empty: it is.
    std::string doubt() const;
    /// The object "journal" of /v1/state.
    std::string json() const;
    /// Its part of /metrics: how full it is, and where others append how it stands with them.
    std::string metrics() const;
};

/// Changes that are listed at once.
inline constexpr std::size_t history_max = 200;

/// A change of the sea that counts: neither one of pace, nor lapsed.
bool changes_the_scene(const SeaChange& change);
/// And one that has begun before: what begins with another takes its place.
bool runs_before(const SeaChange& change, sea::TimeUs time_us);

/// Those from a number on, with the first lines of each scene that differ from what ran when it began: JSON. What comes before that
/// number is there to differ from.
std::string history_json(std::span<const SeaChange> changes, std::uint32_t from);

} // namespace seaway::server
