// SPDX-License-Identifier: Apache-2.0
// Lists of 8-byte values in a message: of these the verifier of flatbuffers proves the alignment of the count alone, and
// reading them elsewhere is undefined. Used by MessageReader only. Pure; thread-safe.
#pragma once

#include "protocol/seaway_generated.h"

namespace seaway::protocol {

/// Whether each of its lists of 8-byte values stands at a multiple of 8, as docs/protocol.md says. The message is verified otherwise.
bool lists_aligned(const wire::Message& message);

} // namespace seaway::protocol
