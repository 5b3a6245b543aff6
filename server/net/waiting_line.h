// SPDX-License-Identifier: Apache-2.0
// WaitingLine: those of whom something is awaited and who make room for newcomers, each with the address
// that it comes from and how to give it up; who waits longest first. Of the io thread alone.
#pragma once

#include <algorithm>
#include <functional>
#include <list>
#include <optional>
#include <utility>

#include "server/net/addresses.h"

namespace seaway::server {

class WaitingLine {
    struct Waiting {
        AddressPtr address;
        std::function<void()> give_up;
    };
    using Places = std::list<Waiting>;

  public:
    /// A place in the line, left with leave() or by its end.
    class Place {
      public:
        Place() = default;
        ~Place() { leave(); }
        Place(const Place&) = delete;
        Place& operator=(const Place&) = delete;

        /// At the end, also where it was in a line already. The line outlives the place.
        void take(WaitingLine& line, AddressPtr address, std::function<void()> give_up) {
            leave();
            at_ = line.places_.insert(line.places_.end(), {std::move(address), std::move(give_up)});
            line_ = &line; // not where there was no memory for it
        }
        void leave() {
            if (WaitingLine* line = std::exchange(line_, nullptr))
                line->places_.erase(at_);
        }

      private:
        WaitingLine* line_ = nullptr;
        Places::iterator at_;
    };

    bool empty() const { return places_.empty(); }
    std::size_t size() const { return places_.size(); }

    /// Gives up the one of `address` that has waited longest; false if there is none.
    bool give_up_of(const Address& address) {
        return give_up(std::find_if(places_.begin(), places_.end(), [&](const Waiting& waiting) {
            return waiting.address.get() == &address;
        }));
    }

    /// Gives up the longest waiting one of the address with the highest count, which has to be above
    /// `more_than`; false if there is none.
    bool give_up_of_most(int Address::*count, int more_than) {
        const auto most = std::max_element(places_.begin(), places_.end(),
                                           [&](const Waiting& a, const Waiting& b) {
                                               return (*a.address).*count < (*b.address).*count;
                                           });
        return most != places_.end() && (*most->address).*count > more_than &&
               give_up_of(*most->address);
    }

  private:
    bool give_up(Places::iterator which) {
        if (which == places_.end())
            return false;
        const auto give_up = which->give_up; // which makes it leave the line
        give_up();
        return true;
    }

    Places places_;
};

} // namespace seaway::server
