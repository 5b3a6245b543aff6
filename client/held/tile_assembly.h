// SPDX-License-Identifier: Apache-2.0
// Tile assembly: parts of maps, as they come over the wire, to whole keyframes.
//
// A tile does not say why it was sent: streamed and fetched copies of one keyframe may come mixed,
// with different sets of fields. So every part is taken once, and a keyframe is handed out when it
// holds all that someone waits for: the fields of the subscription, or those of an open request;
// again if more of its fields complete later. Everything is bounded: the keyframe touched longest
// ago makes room. Bytes that make no sense are an error, after which the connection should be
// closed.
//
// For one thread, but for dropped().
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <list>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "base/large_vector.h"
#include "base/result.h"
#include "client/held/keyframe_ring.h"
#include "client/held/predictions.h"
#include "protocol/messages.h"
#include "sea/surface/maps/regrid.h"

namespace seaway::client {

class TileAssembly {
  public:
    /// Keyframes under way: those of a full fetch (8 times, 2 each, 5 cascades) and of the stream.
    static constexpr std::size_t keyframes_max = 96;
    /// Maps under way, all together.
    static constexpr std::size_t bytes_max = 512u * 1024 * 1024;

    struct Added {
        HeldKeyframePtr complete; ///< null unless this part completed what is waited for
        bool acknowledge = false; ///< all that was streamed of it is there
        /// It is a difference to what is not here, and was left out; so will be all that follow from it.
        bool unpredicted = false;
    };

    /// Takes one part. `cascade`: side and grid of its maps; linear ones that come on a smaller grid (docs/protocol.md,
    /// "Compact maps") are brought to it once they are whole; displacements that follow from heights are made of them in
    /// water of `depth_m` (0: deep), where somebody waits for them. `streamed`: the fields granted to
    /// the subscription (empty: none), of which those at a keyframe's first part count.
    /// `requested`: the fields that each open request waits for. `law`: by which maps are predicted.
    Result<Added> add(const protocol::TileHeader& header, std::span<const std::uint8_t> payload,
                      const protocol::CascadeInfo& cascade, double depth_m, sea::FieldSet streamed,
                      std::span<const sea::FieldSet> requested,
                      const std::optional<sea::WaveLaw>& law = {});

    /// A request has ended, its keyframes have `fields`: those not handed out with them so far.
    std::vector<HeldKeyframePtr> finish(sea::FieldSet fields);

    std::size_t keyframes() const { return pending_.size(); }
    std::size_t bytes() const { return bytes_; }
    /// Keyframes that made room for others before anybody got them. From any thread.
    std::uint64_t dropped() const { return dropped_; }

  private:
    struct Map {
        LargeVector<float> values; ///< [y][x]
        int size = 0;
        std::uint64_t parts_seen = 0;
        std::size_t samples_seen = 0;
        int parts = 0;
        float error = 0;
        sea::FieldSet follows; ///< as its first part said
    };
    struct Pending {
        protocol::TileHeader header; ///< of its first part
        double length_m = 0;
        double depth_m = 0;
        int size = 0;        ///< of the cascade's own grid
        int linear_size = 0; ///< of that on which linear maps come, once one has begun
        sea::FieldSet streamed;
        sea::FieldSet received;   ///< fields of which all parts are there
        sea::FieldSet follows;    ///< what could be made of them
        sea::FieldSet whole;      ///< what is received, and made of that for somebody
        sea::FieldSet handed_out; ///< fields of the last keyframe made from it
        std::array<Map, sea::field_count> maps;
        sea::CodedNoise noise; ///< as a tile of the rates said
        bool repeated = false; ///< what came last had come before
        int finished_then = 0; ///< requests that had ended when it was handed out
        bool stylised = false; ///< as its cascade
    };

    Pending& pending_for(const protocol::TileHeader& header, const protocol::CascadeInfo& cascade,
                         double depth_m, sea::FieldSet streamed);
    Result<void> take(Pending& pending, const protocol::TileHeader& header,
                      std::span<const std::uint8_t> payload, std::span<const float> expected);
    void keep_as_base(const Pending& pending, const protocol::TileHeader& header);
    static Result<void> check_grid(Pending& pending, const protocol::TileHeader& header);
    Result<void> begin_map(Pending& pending, const protocol::TileHeader& header);
    HeldKeyframePtr assemble(Pending& pending);
    /// These maps of a keyframe from the smaller grid, height and its rate aside if something follows from them.
    void enlarge(const Pending& pending, sea::FieldSet fields, sea::Keyframe& keyframe);
    /// Height, its rate and what follows from them.
    void displace(const Pending& pending, sea::Keyframe& keyframe);
    const sea::Regrid& regrid(const Pending& pending);
    const sea::Orbits& orbits(const Pending& pending);
    void drop_oldest();
    void forget(std::list<Pending>::iterator pending);

    std::list<Pending> pending_; ///< touched last: at the back
    Predictions predictions_;
    std::size_t bytes_ = 0;
    std::map<std::pair<int, int>, sea::Regrid> regrids_; ///< by sides, from and to
    /// By size, length and depth.
    std::map<std::tuple<int, double, double>, sea::Orbits> orbits_;
    std::atomic<std::uint64_t> dropped_ = 0;
    int finished_ = 0; ///< requests that have ended
};

} // namespace seaway::client
