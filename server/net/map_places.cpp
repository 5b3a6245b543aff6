// SPDX-License-Identifier: Apache-2.0
#include "server/net/map_places.h"

#include <algorithm>
#include <new>
#include <utility>

#include "base/undo.h"

namespace seaway::server {

bool MapPlaces::ask(const AddressPtr& address, Begin begin, Waits waits) {
    take_returned(state_);
    forget_who_left(*state_);
    if (state_->taken < state_->most) {
        ++state_->by_address[address.get()];
        begin(place(state_, address));
        return true;
    }
    if (static_cast<int>(state_->waiting.size()) < state_->ending) {
        wait(address, std::move(begin), std::move(waits));
        return true;
    }
    if (state_->most == 0)
        return false; // it stops
    if (!make_room() && state_->by_address.contains(address.get()))
        return false;
    wait(address, std::move(begin), std::move(waits));
    return true;
}

bool MapPlaces::make_room() {
    std::shared_ptr<MapReader> slowest;
    std::erase_if(readers_, [&slowest](const std::weak_ptr<MapReader>& weak) {
        const std::shared_ptr<MapReader> reader = weak.lock();
        if (reader == nullptr)
            return true;
        if (reader->behind() > (slowest ? slowest->behind() : std::chrono::seconds(0)))
            slowest = reader;
        return false;
    });
    if (slowest == nullptr)
        return false;
    std::erase_if(readers_, [&slowest](const auto& weak) { return weak.lock() == slowest; });
    slowest->give_way();
    return true;
}

void MapPlaces::look_again() {
    take_returned(state_);
    forget_who_left(*state_);
    next_begins(state_); // for whom there was no memory
    if (static_cast<int>(state_->waiting.size()) > state_->ending)
        make_room();
}

void MapPlaces::wait(const AddressPtr& address, Begin begin, Waits waits) {
    ++state_->by_address[address.get()];
    Undo counted([&] { give_back(*state_, address); });
    state_->waiting.push_back({address, std::move(begin), std::move(waits)});
    counted.keep();
}

void MapPlaces::forget_who_left(State& state) {
    std::erase_if(state.waiting, [&state](const Waiting& one) {
        const bool left = !one.waits();
        if (left)
            give_back(state, one.address);
        return left;
    });
}

void MapPlaces::give_back(State& state, const AddressPtr& address) {
    if (const auto held = state.by_address.find(address.get()); --held->second == 0)
        state.by_address.erase(held);
}

void MapPlaces::reads(std::weak_ptr<MapReader> reader) {
    std::erase_if(readers_, [](const auto& weak) { return weak.expired(); });
    readers_.push_back(std::move(reader));
}

void MapPlaces::stop() {
    std::deque<Waiting> forgotten;
    forgotten.swap(state_->waiting);
    state_->most = 0;
}

MapPlaces::Place MapPlaces::place(const std::shared_ptr<State>& state, const AddressPtr& address) {
    Undo counted([&] { give_back(*state, address); });
    auto one = std::make_shared<std::list<Returned>>(1, Returned{address});
    counted.keep(); // what fails from here on gives it back as any place
    ++state->taken;
    return Place(state.get(), GiveBack{state, std::move(one)});
}

void MapPlaces::GiveBack::operator()(void*) const {
    {
        const std::scoped_lock lock(state->mutex);
        state->returned.splice(state->returned.end(), *place);
    }
    try {
        state->post([state = state] { take_returned(state); });
    } catch (const std::bad_alloc&) { // who asks next takes it, or who waits, each second
    }
}

void MapPlaces::take_returned(const std::shared_ptr<State>& state) {
    for (;;) { // one by one: who begins in its place may find no memory for that
        std::list<Returned> one;
        {
            const std::scoped_lock lock(state->mutex);
            if (state->returned.empty())
                return;
            one.splice(one.end(), state->returned, state->returned.begin());
        }
        gave_back(state, one.front());
    }
}

void MapPlaces::gave_back(const std::shared_ptr<State>& state, const Returned& returned) {
    --state->taken;
    state->ending -= returned.ended;
    give_back(*state, returned.address);
    forget_who_left(*state);
    next_begins(state);
}

void MapPlaces::next_begins(const std::shared_ptr<State>& state) {
    if (state->waiting.empty() || state->taken >= state->most)
        return;
    const AddressPtr address = state->waiting.front().address;
    ++state->by_address
          [address.get()]; // of the place: where there is no memory for it the line is as it was
    Place its = place(state, address);
    const Waiting next = std::move(state->waiting.front());
    state->waiting.pop_front();
    give_back(*state, address); // of the line
    next.begin(std::move(its));
}

} // namespace seaway::server
