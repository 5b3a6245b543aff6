// SPDX-License-Identifier: Apache-2.0
// How much of a sea is white: the share that was photographed at a wind, and which wind a sea
// without one is taken to have.
//
// Pure functions; thread-safe.
#pragma once

#include <string>

#include "sea/waves/sea_state.h"

namespace seaway::sea {

/// Share of the surface that whitecaps cover at a wind at 10 m, 0 .. 0.076; not falling, without a jump:
///
///     0                              up to 3.70 m/s
///     3.18e-5 (U - 3.70)^3           up to 10.19 m/s, where the two pieces meet
///     4.82e-6 (U + 1.98)^3           up to 23.09 m/s
///     0.0759                         above
///
/// Callaghan, de Leeuw, Cohen and O'Dowd 2008 (Geophys. Res. Lett. 35, L23609; in percent there); their
/// pieces hold for 3.70 .. 11.25 and 9.25 .. 23.09 m/s. Where their data end the share is held: in higher
/// winds whitecaps do not become more (Holthuijsen, Powell and Pietrzak 2012) and stay below a tenth
/// (Brumer et al. 2017); spray and streaks, which whiten a hurricane, are no whitecaps.
double whitecap_share(double wind_speed_10m_mps);

/// The wind that a sea's foam goes by.
struct FoamWind {
    enum class Origin {
        given,      ///< the strongest of the sea's wind systems
        equivalent, ///< no wind is given; that of a grown sea like the steep part of the spectrum
        swell,      ///< no wind is given, and no frequency is as steep as a wind sea: no foam
        by_hand,    ///< no wind and no spectrum, explicit waves alone: no foam
    };
    double speed_10m_mps = 0.0;
    Origin origin = Origin::by_hand;
};

/// Without a wind the wind sea is the frequencies at which S is at least the peak of the
/// Pierson-Moskowitz spectrum that peaks there (the test of Portilla, Ocampo-Torres and Monbaliu 2009,
/// made at each frequency instead of at each peak), and the wind is that of the Pierson-Moskowitz sea
/// with this variance above its peak. A grown sea so gets its own wind back; a young sea, which
/// stronger wind raised, gets less than that wind. About 2 ms.
FoamWind foam_wind(const SeaState& sea);

/// "at 19 m/s", "at 10.5 m/s, the wind of a grown sea like its wind sea", or why there is none.
std::string describe(const FoamWind& wind);

} // namespace seaway::sea
