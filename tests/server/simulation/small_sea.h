// SPDX-License-Identifier: Apache-2.0
// A small explicit sea behind server::Host, for tests of the net without a simulation.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "protocol/messages.h"
#include "server/host/host.h"

namespace seaway::tests {

using server::KeyframeTiles;

/// Keyframes lie at whole multiples of this.
inline constexpr sea::TimeUs interval_us = 100'000;
inline constexpr float codec_error = 0.01f;

/// What sample (x, y) of a field of keyframe n is: different everywhere, so that nothing can be
/// mixed up unseen.
inline float sample_value(int cascade, std::int64_t n, sea::Field field, int x, int y) {
    return static_cast<float>(std::sin(0.7 * x + 0.3 * y + 0.1 * static_cast<double>(n)) +
                              10 * cascade + static_cast<int>(field));
}

/// A sea of explicit keyframes: two cascades, any field, answers that are sums of the coordinates.
class SmallSea : public server::Host {
  public:
    int size = 32;
    std::vector<float> error{}; ///< codec bound of every field; empty: codec_error
    sea::FieldSet offered = sea::surface_fields | sea::FieldSet{sea::Field::foam};
    std::vector<protocol::SharedBytes> states{state_message(0)};
    std::atomic<bool> answer_queries = true; ///< else they wait in `unanswered`
    std::atomic<bool> answer_fetches = true; ///< else they wait in `unanswered`
    std::atomic<bool> coarser_now = false;   ///< the sea that runs has the coarser rung alone
    std::atomic<bool> deep = false;          ///< of compact maps displacements follow from heights
    std::atomic<bool> is_busy = false;       ///< queries, fetches and maps are refused

    static protocol::SharedBytes state_message(std::uint32_t epoch, std::size_t scene_bytes = 100) {
        protocol::SeaStateValues state;
        state.epoch = epoch;
        for (int cascade = 0; cascade < 2; ++cascade)
            state.cascades.push_back({.length_m = cascade == 0 ? 1021.0 : 197.0,
                                      .size = 32,
                                      .k_lo_radpm = 0.1,
                                      .k_hi_radpm = 0.2,
                                      .interval_us = interval_us});
        state.scene.assign(scene_bytes, 's');
        return std::make_shared<const protocol::Bytes>(protocol::sea_state(state));
    }

    /// Two rungs: who is content with 0.1 m gets the coarse one.
    static server::Quality quality(const server::Demand& demand) {
        return demand.error_m >= bound(1) ? 1 : 0;
    }
    static constexpr float bound(server::Quality quality) { return quality == 0 ? 0.02f : 0.1f; }

    KeyframeTiles keyframe(int cascade, std::int64_t n, sea::FieldSet fields,
                           server::Quality quality = 0) const {
        auto made = std::make_shared<sea::Keyframe>();
        made->cascade = cascade;
        made->time_us = n * interval_us;
        made->size = size;
        made->length_m = cascade == 0 ? 1021.0 : 197.0;
        made->fields = fields;
        made->values.resize(made->plane_size() * static_cast<std::size_t>(fields.size()));
        for (const sea::Field field : fields) {
            auto plane = made->plane(field);
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x)
                    plane[static_cast<std::size_t>(y * size + x)] =
                        sample_value(cascade, n, field, x, y);
        }
        const float codec = (error.empty() ? codec_error : error.front()) * (quality == 0 ? 1 : 8);
        return {.keyframe = made,
                .codec_error = std::vector<float>(static_cast<std::size_t>(fields.size()), codec),
                .quality = quality};
    }

    /// As a server does whose budget of memory is so large.
    void holds(std::size_t bytes) { memory_ = std::make_shared<server::Memory>(bytes); }

    // ---- Host ------------------------------------------------------------------------------

    sea::TimeUs sea_time_us() const override {
        ++times_told;
        return newest * interval_us;
    }
    mutable std::atomic<int> times_told = 0; ///< each Ping asks for one
    std::vector<protocol::SharedBytes> sea_state_messages() const override {
        network = std::this_thread::get_id();
        return states;
    }
    mutable std::atomic<std::thread::id> network{}; ///< where sessions are greeted
    mutable std::atomic<int> looked_up = 0, looked_up_by_network = 0; ///< states of one epoch
    protocol::SharedBytes sea_state_message(std::uint32_t epoch) const override {
        ++looked_up;
        looked_up_by_network += std::this_thread::get_id() == network.load();
        const auto told = told_later.find(epoch);
        return told == told_later.end() ? nullptr : told->second;
    }
    std::map<std::uint32_t, protocol::SharedBytes>
        told_later; ///< by epoch, where its waves are sent
    server::Demand grant(const server::Demand& wish,
                         std::optional<server::SessionId> = {}) const override {
        server::Demand grant = wish;
        grant.cascades &= 3u;
        grant.fields = wish.fields & offered;
        grant.quality = quality(wish);
        grant.error_m = bound(grant.quality);
        if (coarser_now) { // whatever was wished for
            grant.quality = 1;
            grant.error_m = bound(1);
            grant.why = "the sea has grown";
        }
        if (deep && wish.compact) {
            grant.follows = grant.fields & sea::following(grant.fields);
            grant.fields = grant.fields.without(grant.follows);
        }
        return grant;
    }
    Result<std::string> history(std::uint64_t /*from*/) const override {
        while (disk_hangs)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return std::string("{}");
    }
    std::atomic<bool> disk_hangs = false; ///< that of its journal
    void fetch(server::FetchRequest request, Fetched done) override {
        askers.push_back(request.asker);
        if (is_busy)
            return done(Error{server::Refusal::busy, "later"});
        if ((request.demand.fields.bits() & offered.bits()) == 0)
            return done(Error{server::Refusal::not_offered, "none of these fields"});
        std::set<std::int64_t> wanted{newest, newest + 1};
        if (!request.times_us.empty())
            wanted.clear();
        for (const sea::TimeUs time_us : request.times_us) {
            wanted.insert(time_us / interval_us);
            wanted.insert(time_us / interval_us + 1);
        }
        std::vector<KeyframeTiles> out;
        for (int cascade = 0; cascade < 2; ++cascade)
            if ((request.demand.cascades >> cascade) & 1u)
                for (const std::int64_t n : wanted)
                    out.push_back(keyframe(cascade, n, held(cascade, request.demand.fields),
                                           quality(request.demand)));
        if (answer_fetches)
            done(server::FetchedPart{std::move(out)});
        else
            unanswered.push_back([done, out] { done(server::FetchedPart{out}); });
    }
    void query(server::QueryBatch batch, Queried done) override {
        askers.push_back(batch.asker);
        if (on_query)
            on_query();
        if (is_busy)
            return done(Error{server::Refusal::busy, "later"});
        server::QueryAnswers out{.epoch = answering_epoch, .answers = {}};
        for (const sea::QueryPoint& point : batch.points) {
            sea::Answer answer;
            answer.height_m = point.x_m + point.y_m;
            answer.error_m = 0.01;
            answer.flags = batch.exact ? sea::answer_exact : 0u;
            out.answers.push_back(answer);
        }
        if (batch.looking != sea::Looking{})
            out.cascades = batch.looking.cascades & 3u;
        if (answer_queries)
            done(std::move(out));
        else
            unanswered.push_back([done, out] { done(out); });
    }
    Result<server::GrantedSpectrum> spectrum(const server::SpectrumRequest& request) override {
        ++spectra_asked;
        while (spectra_take_long)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        const std::scoped_lock lock(spectra_mutex);
        if (no_memory_for_spectra)
            throw std::bad_alloc();
        if (no_room_for_spectra)
            return Error{server::Refusal::busy, "no room"};
        if (spectra.empty())
            return Error{server::Refusal::not_offered, "no waves here"};
        return server::GrantedSpectrum{0.01f, 0.005f, request.wish.fields, "less", spectra};
    }
    std::optional<server::GrantedSpectrum>
    held_spectrum(const server::SpectrumRequest& request) override {
        const std::scoped_lock lock(spectra_mutex);
        if (!spectra_held || spectra.empty())
            return std::nullopt;
        return server::GrantedSpectrum{0.01f, 0.005f, request.wish.fields, "held", spectra};
    }
    /// The spectrum of an epoch in so many chunks.
    static server::EncodedSpectrumPtr spectrum_of(std::uint32_t epoch, std::uint32_t chunks,
                                                  std::size_t chunk_bytes = 100) {
        auto made = std::make_shared<server::EncodedSpectrum>();
        made->epoch = epoch;
        const auto add = [&](protocol::Bytes bytes) {
            made->bytes += bytes.size();
            made->messages.push_back(std::make_shared<const protocol::Bytes>(std::move(bytes)));
        };
        add(protocol::spectrum({.epoch = epoch, .chunks = chunks, .steps = {1e-3, 0}}));
        const std::vector<std::uint8_t> payload(chunk_bytes);
        for (std::uint32_t chunk = 0; chunk < chunks; ++chunk)
            add(protocol::spectrum_chunk(epoch, chunk, {}, payload));
        return made;
    }
    void offer_spectra(std::vector<server::EncodedSpectrumPtr> all) {
        const std::scoped_lock lock(spectra_mutex);
        spectra = std::move(all);
    }
    void map(server::MapQuery query, Mapped done) override {
        askers.push_back(query.asker);
        ++maps_asked;
        map_parameters = query.parameters;
        if (is_busy)
            return done(Error{server::Refusal::busy, "later"});
        if (!answer_maps)
            return unanswered.push_back([] {});
        auto rows = std::make_unique<Rows>(*this, std::move(query.on_ready));
        done(std::unique_ptr<server::ByteSource>(std::move(rows)));
    }
    Result<std::uint64_t>
    map_bytes(const std::map<std::string, std::string>& parameters) const override {
        if (parameters.contains("colour"))
            return Error{server::Refusal::bad_value, "unknown parameter \"colour\""};
        return map_bytes_all;
    }
    std::string state_json() const override {
        if (on_state)
            on_state();
        return "{\"sea\":1}";
    }
    std::string plan_json() const override { return "{\"plan\":1}"; }
    std::string metrics_text() const override {
        return "# HELP seaway_simulation_up 1 while it runs.\n"
               "# TYPE seaway_simulation_up gauge\nseaway_simulation_up 1\n";
    }
    server::Health health() const override {
        if (well && doubts)
            return {true, "secret.stream has not been heard of", false,
                    "it is not sure of its sea"};
        return {well, well ? "" : "the simulation has failed"};
    }

    std::mutex spectra_mutex; ///< asked for on a thread of their own
    std::vector<server::EncodedSpectrumPtr> spectra;
    std::atomic<int> spectra_asked = 0;
    std::atomic<bool> no_room_for_spectra = false;
    std::atomic<bool> no_memory_for_spectra = false;
    std::atomic<bool> spectra_held = false; ///< else they have to be made
    std::atomic<bool> spectra_take_long = false;
    static constexpr std::uint32_t answering_epoch = 7; ///< of queries
    std::atomic<std::int64_t> newest = 0;
    std::atomic<bool> well = true;
    std::atomic<bool> doubts = false; ///< its sea, while it is well
    std::vector<std::function<void()>> unanswered;
    std::vector<server::Asker> askers; ///< of every question, in order
    std::shared_ptr<std::atomic<int>> maps_alive = std::make_shared<std::atomic<int>>(0);
    std::atomic<int> maps_asked = 0;
    std::map<std::string, std::string> map_parameters; ///< of the last one
    std::atomic<bool> answer_maps = true;              ///< else nobody hears of them again
    std::atomic<bool> maps_ready = false; ///< else their rows never come, but in map_piece_bytes
    bool maps_fail = false;               ///< after their header
    static constexpr std::size_t map_chunk_bytes = 500, map_chunks = 2;
    std::size_t map_bytes_all = map_chunks * map_chunk_bytes;
    std::size_t map_piece_bytes = 0;
    std::function<void()> on_map_end = {};   ///< where a map ends
    std::function<void()> on_state = {};     ///< where /v1/state is made
    std::function<void()> on_query = {};     ///< where a question comes
    std::map<int, sea::FieldSet> lacks = {}; ///< fields that keyframes of a cascade do not hold

  private:
    sea::FieldSet held(int cascade, sea::FieldSet fields) const {
        const auto found = lacks.find(cascade);
        return found == lacks.end() ? fields : fields.without(found->second);
    }

    class Rows final : public server::ByteSource {
      public:
        /// Keeps `on_ready` for as long as it lives, as who makes rows on threads of its own does.
        Rows(const SmallSea& sea, std::function<void()> on_ready)
            : on_ready_(std::move(on_ready)), sea_(sea), alive_(sea.maps_alive) {
            ++*alive_;
        }
        ~Rows() override {
            if (sea_.on_map_end)
                sea_.on_map_end();
            --*alive_;
        }
        bool failed() const override { return sea_.maps_fail; }
        std::uint64_t size() const override { return sea_.map_bytes_all; }
        std::vector<std::uint8_t> next() override {
            const std::size_t most = sea_.maps_ready ? map_chunk_bytes : sea_.map_piece_bytes;
            const std::size_t piece =
                sea_.maps_fail ? 0 : std::min(most, sea_.map_bytes_all - given_);
            given_ += piece;
            return std::vector<std::uint8_t>(piece, 'm');
        }

      private:
        const std::function<void()> on_ready_;
        const SmallSea& sea_;
        std::shared_ptr<std::atomic<int>> alive_;
        std::size_t given_ = 0;
    };
};

} // namespace seaway::tests
