// SPDX-License-Identifier: Apache-2.0
#include "protocol/list_alignment.h"

#include <cstdint>

namespace seaway::protocol {
namespace {

template <class Vector>
bool aligned(const Vector* list) {
    return list == nullptr || list->size() == 0 ||
           reinterpret_cast<std::uintptr_t>(list->Data()) % alignof(std::uint64_t) == 0;
}

} // namespace

bool lists_aligned(const wire::Message& message) {
    using wire::Body;
    switch (message.body_type()) { // no default: a new kind must be thought of
    case Body::Ack:
        return aligned(message.body_as_Ack()->also());
    case Body::Fetch:
        return aligned(message.body_as_Fetch()->times_us());
    case Body::Query:
        return aligned(message.body_as_Query()->points()) &&
               aligned(message.body_as_Query()->z_m());
    case Body::SeaState:
        return aligned(message.body_as_SeaState()->cascades()) &&
               aligned(message.body_as_SeaState()->probes()) &&
               aligned(message.body_as_SeaState()->leads_to()) &&
               aligned(message.body_as_SeaState()->glide_k_lo_radpm());
    case Body::QueryReply:
        return aligned(message.body_as_QueryReply()->answers());
    case Body::NONE:
    case Body::Hello:
    case Body::Subscribe:
    case Body::Unsubscribe:
    case Body::Ping:
    case Body::Change:
    case Body::Administer:
    case Body::Changed:
    case Body::Administered:
    case Body::Pace:
    case Body::Welcome:
    case Body::Subscribed:
    case Body::Tile:
    case Body::FetchDone:
    case Body::Pong:
    case Body::Refused:
    case Body::GoAway:
    case Body::SubscribeSpectrum:
    case Body::SpectrumSubscribed:
    case Body::Spectrum:
    case Body::SpectrumChunk:
        break;
    }
    return true;
}

} // namespace seaway::protocol
