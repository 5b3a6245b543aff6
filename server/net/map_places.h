// SPDX-License-Identifier: Apache-2.0
// MapPlaces: how many maps are under way at a time, and who gives way. A place comes back when the last of its
// holders lets it go, on whichever thread, which is after the threads of the map have ended. Where none is free,
// the reader who is furthest behind makes room, if one is behind; who asked waits for that place. An address that has no
// place waits for the next that comes free, in the order in which they ask: so one that always wants two leaves others theirs.
//
// Of the io thread alone, but for the places.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "server/net/addresses.h"

namespace seaway::server {

/// Somebody who is sent a map.
class MapReader {
  public:
    virtual ~MapReader() = default;
    /// For how long it has kept the server waiting, beyond what it has earned by reading; 0: not behind.
    virtual std::chrono::duration<double> behind() const = 0;
    /// Somebody else wants the place.
    virtual void give_way() = 0;
};

class MapPlaces {
  public:
    using Place = std::shared_ptr<void>;
    using Begin = std::function<void(Place)>;
    using Waits = std::function<bool()>;
    /// Hands work to the io thread.
    using Post = std::function<void(std::function<void()>)>;

    MapPlaces(int most, Post post) : state_(std::make_shared<State>()) {
        state_->most = most;
        state_->post = std::move(post);
    }

    /// Calls `begin` now, or once a place has come free, for who then still waits. False: none is, nobody is behind, and this address
    /// has a place, or waits for one.
    [[nodiscard]] bool ask(const AddressPtr& address, Begin begin, Waits waits);

    /// To be called each second by who waits: a reader may have fallen behind since it asked.
    void look_again();

    /// For as long as it lives it may be asked to give way.
    void reads(std::weak_ptr<MapReader> reader);

    /// That place will come back soon.
    void ends(const Place& place) {
        bool& ended = std::get_deleter<GiveBack>(place)->place->front().ended;
        state_->ending += !ended;
        ended = true;
    }

    /// Those who wait are forgotten.
    void stop();

  private:
    struct Waiting {
        AddressPtr address;
        Begin begin;
        Waits waits; ///< false: it has left
    };
    /// What a place takes to be given back, made when it is taken: it may come back where there is no memory.
    struct Returned {
        AddressPtr address;
        bool ended = false;
    };
    struct State {
        int most = 0;
        int taken = 0;
        int ending = 0; ///< of these
        std::deque<Waiting> waiting;
        std::map<const Address*, int> by_address; ///< places that each has or waits for
        Post post;
        std::mutex mutex;
        std::list<Returned> returned; ///< by any thread, until the io thread takes them
    };
    struct GiveBack {
        std::shared_ptr<State> state;
        std::shared_ptr<std::list<Returned>> place; ///< one
        void operator()(void*) const;
    };
    static Place place(const std::shared_ptr<State>& state, const AddressPtr& address);
    static void take_returned(const std::shared_ptr<State>& state);
    static void gave_back(const std::shared_ptr<State>& state, const Returned& returned);
    /// Who is first in line, if a place is free.
    static void next_begins(const std::shared_ptr<State>& state);
    void wait(const AddressPtr& address, Begin begin, Waits waits);
    static void forget_who_left(State& state);
    static void give_back(State& state, const AddressPtr& address);
    /// The reader who is furthest behind gives way; false: none is behind.
    bool make_room();

    const std::shared_ptr<State> state_;
    std::vector<std::weak_ptr<MapReader>> readers_;
};

} // namespace seaway::server
