// SPDX-License-Identifier: Apache-2.0
// Session::ask_behind, for the parts of a session that ask so.
#pragma once

#include <memory>
#include <new>
#include <utility>

#include "base/for_want_of_memory.h"
#include "server/net/fetch_job.h"
#include "server/net/session.h"

namespace seaway::server {

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
        (void)tried_for_a_second([&] {
            core->post([weak, id, take, said] {
                const std::shared_ptr<Core> here = weak.lock();
                if (Session* found = here ? here->find(id) : nullptr)
                    found->or_drop([&] { take(*found, said); });
            });
        });
        return true;
    };
    return core_.spectra.submit_start(job);
}

} // namespace seaway::server
