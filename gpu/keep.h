// SPDX-License-Identifier: Apache-2.0
// For who makes many things of a device in a row.
#pragma once

#include <utility>

#include "base/result.h"

namespace seaway::gpu {

/// Puts what was made into `target`, or hands its error on: SEAWAY_TRY(keep(buffer, Buffer::create(...))).
template <class T>
Result<void> keep(T& target, Result<T> made) {
    if (!made)
        return made.error();
    target = std::move(*made);
    return {};
}

} // namespace seaway::gpu
