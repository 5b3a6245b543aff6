// SPDX-License-Identifier: Apache-2.0
// WavesOf: what a client has of the waves of a sea, and of a glide of those that led there. Taken within moments; to make a sea of
// them takes some tens of milliseconds.
#pragma once

#include <memory>

#include "client/rebuilt/held_glides.h"
#include "client/rebuilt/received_spectrum.h"

namespace seaway::client {

struct WavesOf {
    SeaStatePtr state;
    // Of a glide, its end.
    RebuiltSeaPtr made = nullptr; ///< from its scene
    std::shared_ptr<ReceivedSpectrum> received = nullptr;
    std::unique_ptr<WavesOf> before = nullptr; ///< of a glide: where it begins
    bool steady = false;                       ///< a glide whose end is meant

    explicit operator bool() const { return made || received; }
    RebuiltSeaPtr end() const; ///< null: nothing of it has come yet
    GlideEnds ends() const;    ///< of a glide; empty: one of them has not come
};

} // namespace seaway::client
