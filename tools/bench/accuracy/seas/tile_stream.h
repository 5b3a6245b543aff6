// SPDX-License-Identifier: Apache-2.0
// The tiles of one client: keyframes as the server's encoder sends them at the best rung, and as the client's assembly has them
// again. What is sent and what that takes is counted, headers of messages included.
//
// Predicted keyframes follow each other: what rounding left of the one before is part of the next. One that does not follow the
// last begins a stream anew; who measures lets some go before it (`leads`), so that it is one of a stream that goes on.
//
// For one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.h"
#include "client/held/tile_assembly.h"
#include "sea/surface/maps/keyframe.h"
#include "server/host/quality.h"
#include "server/publish/encoder.h"
#include "tools/bench/accuracy/seas/configuration.h"
#include "tools/bench/accuracy/seas/waves.h"

namespace seaway::bench {

/// What sending the keyframes of a cascade took, leads left out. CPU seconds, so that other programs do not count.
struct CodingCost {
    std::uint64_t keyframes = 0;
    std::uint64_t bytes = 0; ///< of the messages that are sent
    std::uint64_t bytes_made =
        0; ///< of those that were encoded: of predicted ones there are two forms
    double encode_s = 0;
    double decode_s = 0; ///< a client's, to whole keyframes on the cascade's own grid
    double worst_over_bound =
        0; ///< largest |decoded - sent| in units of the codec's bound, on the grid that is sent
};

class TileStream {
  public:
    /// Keyframes before one that is measured. The first differences of a stream are twice as long as later ones; after so many
    /// they are within a few percent of what they are for ever.
    static constexpr int leads = 16;

    /// `waves.budget` says how keyframes lie; `codec_error_m` (above 0) what coding may cost of a height.
    TileStream(const Waves& waves, Tiles form, double codec_error_m);

    /// Of so many keyframes before the one of this time the stream has to be sent first.
    int leads_to(int cascade, sea::TimeUs time_us) const;

    /// Encodes a keyframe that others follow, with heights and their rates at least; counts nothing.
    Result<void> lead(sea::Keyframe& keyframe);
    /// The keyframe becomes what the client has of it, its fields all the same. The leads are sent.
    Result<void> send(sea::Keyframe& keyframe);

    const std::vector<CodingCost>& costs() const { return costs_; }

  private:
    /// By cascade.
    struct Stream {
        std::uint32_t epoch =
            0; ///< counts up with each that begins: nothing is predicted from another one's
        server::EncodedKeyframePtr last = nullptr;
        bool taken = false; ///< by the client; of leads it needs the last alone
    };
    bool follows_last(int cascade, sea::TimeUs time_us) const;
    /// Gives the client the last keyframe of the cascade, whole or as the difference to the one before.
    Result<client::HeldKeyframePtr> take(const sea::Keyframe& keyframe, bool differs);
    Result<double> worst_over_bound(const sea::Keyframe& keyframe,
                                    const server::EncodedKeyframe& encoded) const;

    sea::ErrorBudget budget_; ///< with the codec's error that was asked for
    double depth_m_;
    server::Quality quality_;
    std::optional<sea::WaveLaw> law_;
    server::Encoder encoder_;
    client::TileAssembly assembly_;
    std::vector<CodingCost> costs_;
    std::vector<Stream> streams_;
};

} // namespace seaway::bench
