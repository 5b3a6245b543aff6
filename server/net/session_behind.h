// SPDX-License-Identifier: Apache-2.0
// What comes back to a session from other threads: Session::later and Session::ask_behind.
#pragma once

#include <memory>
#include <new>
#include <utility>

#include "base/for_want_of_memory.h"
#include "server/host/refusal.h"
#include "server/net/session.h"

namespace seaway::server {

template <class Take>
void Session::later(const std::weak_ptr<Core>& core, SessionId id, Take take) {
    if (const std::shared_ptr<Core> alive = core.lock())
        alive->post([core, id, take = std::move(take)] {
            const std::shared_ptr<Core> here = core.lock();
            if (Session* found = here ? here->find(id) : nullptr)
                found->or_drop([&] { take(*found); });
        });
}

template <class Ask, class Take>
bool Session::ask_behind(Ask ask, Take take) {
    const auto job = [weak = core_.weak_from_this(), id = id_, ask = std::move(ask),
                      take = std::move(take)](Encoder&) {
        const std::shared_ptr<Core> core = weak.lock();
        if (core == nullptr)
            return true;
        const auto answer = [&]() -> decltype(ask(core->host)) {
            try {
                return ask(core->host);
            } catch (const std::bad_alloc&) { // who asks waits for an answer
                return no_memory();
            }
        };
        const auto said = answer();
        // It is counted until it is told.
        (void)tried_for_a_second(
            [&] { later(weak, id, [take, said](Session& found) { take(found, said); }); });
        return true;
    };
    return core_.spectra.submit_start(job);
}

} // namespace seaway::server
