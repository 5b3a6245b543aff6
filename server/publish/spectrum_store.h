// SPDX-License-Identifier: Apache-2.0
// SpectrumStore: the waves of a sea as wire messages, once for each of a few accuracies, kept for as long as the
// sea is one of the newest sixteen and there is room. What a client wishes for gets the coarsest accuracy that keeps it,
// what is finer than all the finest; 0 the sea's own height_error_m, and the finest slopes.
//
// What is kept has its place in a room, and keeps it for as long as somebody still has a message of it to send. Where
// the room is full, what nobody reads is let go of, oldest use first, and made again when it is asked for. Where readers
// fill it, who asks gets something finer that is there, or is refused as busy.
//
// Thread-safe; one caller at a time makes something, the others wait, but for those who ask for what is held. Cost where
// nothing is held: 0.2 to 0.4 us a grid point of the sea, of a gale 0.05 s.
#pragma once

#include <array>
#include <atomic>
#include <compare>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "base/result.h"
#include "server/host/encoded_spectrum.h"
#include "server/host/memory.h"
#include "server/publish/encode_spectrum.h"

namespace seaway::server {

/// Bounds on heights, in shares of the sea's height_error_m. A client that has the waves adds nothing to them, and may want
/// finer ones than tiles give.
inline constexpr std::array<double, 7> height_rungs{0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0};
/// The one of the sea's own.
inline constexpr std::size_t own_height_rung = 2;
/// Bounds on slopes; the last rung has none.
inline constexpr std::array<double, 5> slope_rungs{0.005, 0.01, 0.02, 0.05,
                                                   std::numeric_limits<double>::infinity()};

/// An accuracy of these.
struct SpectrumRung {
    std::size_t height = height_rungs.size() - 1;
    std::size_t slope = slope_rungs.size() - 1;
    auto operator<=>(const SpectrumRung&) const = default;
};
inline constexpr SpectrumRung coarsest_rung{};

class SpectrumStore {
  public:
    explicit SpectrumStore(std::shared_ptr<Room> room = Memory().room(MemoryUse::spectra))
        : room_(std::move(room)) {}

    /// Errors, of kind Refusal: not_offered for a sea of stylised waves, which are no modes, and for one whose
    /// spectrum is larger than the wire takes at every accuracy; busy where there is no room, with the time to ask again.
    Result<GrantedSpectrum> grant(const SpectrumSource& sea, const SpectrumDemand& wish);
    /// Of several seas, the first of which is the one that runs; bounds are the largest of them. One of the others that
    /// has no spectrum is named and left out; where there is no room for one there is none of them.
    Result<GrantedSpectrum> grant(std::span<const SpectrumSource> seas, const SpectrumDemand& wish);
    /// The same at once, without making anything; none where that cannot be.
    std::optional<GrantedSpectrum> held(std::span<const SpectrumSource> seas,
                                        const SpectrumDemand& wish);
    /// Grid points of the seas that grant() would make something of.
    std::size_t points_to_make(std::span<const SpectrumSource> seas, const SpectrumDemand& wish);

    /// Spectra that were made so far.
    std::uint64_t made_so_far() const { return made_so_far_; }

  private:
    using Rung = SpectrumRung;
    struct Made {
        EncodedSpectrumPtr spectrum = nullptr; ///< null: let go of, or larger than the wire takes
        std::size_t bytes = 0;                 ///< 0: larger than the wire takes
        double slope_error = 0;
        std::uint64_t used = 0;            ///< of uses_
        std::optional<Error> refused = {}; ///< why there is none
        bool known() const { return spectrum != nullptr || bytes == 0; }
    };
    /// What is at a rung, or why it cannot be had.
    using Find = std::function<Result<Made>(const SpectrumSource&, const Rung&)>;

    static Rung wished(const SpectrumSource& sea, const SpectrumDemand& wish);
    Result<GrantedSpectrum> grant(std::span<const SpectrumSource> seas, const SpectrumDemand& wish,
                                  const Find& find);
    Result<GrantedSpectrum> grant_one(const SpectrumSource& sea, const SpectrumDemand& wish,
                                      const Find& find);
    /// An error, busy: it is not there. Another: it was refused.
    Result<Made> find_held(const SpectrumSource& sea, const Rung& rung);
    Result<Made> find_or_make(const SpectrumSource& sea, const Rung& rung);
    Result<Made> make(const SpectrumSource& sea, const Rung& rung);

    // With mutex_ locked.
    std::map<Rung, Made>& of_sea(std::uint32_t epoch);
    /// There is room for so many bytes, or will be once what nobody reads is let go of.
    bool may_fit(std::size_t bytes) const;
    Room::Place take(std::size_t bytes);
    /// Something as fine that is held, or an error, busy.
    Result<Made> instead_of(std::map<Rung, Made>& rungs, const Rung& rung);

    const std::shared_ptr<Room> room_;
    std::mutex making_;
    std::mutex mutex_;                                   ///< of what follows
    std::map<std::uint32_t, std::map<Rung, Made>> made_; ///< by epoch
    std::uint64_t uses_ = 0;
    std::atomic<std::uint64_t> made_so_far_ = 0;
};

} // namespace seaway::server
