// SPDX-License-Identifier: Apache-2.0
// What the net has done since the start, and its part of /metrics. Of the io thread alone.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "server/net/durations.h"
#include "server/publish/encoder.h"
#include "server/publish/outbox.h"

namespace seaway::server {

/// Why sessions ended besides the error codes of the wire (protocol::name).
inline constexpr std::string_view closed_by_client = "closed_by_client";
inline constexpr std::string_view disconnected = "disconnected"; ///< without a closing handshake

/// Of a query that is counted as one of few.
inline constexpr std::size_t few_points = 16;

struct Counters {
    std::uint64_t connections_accepted = 0;
    std::map<std::string, std::uint64_t, std::less<>> connections_refused{{"address_full", 0},
                                                                          {"server_full", 0}};
    std::uint64_t connections_given_up = 0; ///< without a whole request, for a newcomer
    std::uint64_t handshakes_failed = 0;    ///< TLS, HTTP or WebSocket bytes that were none
    std::map<unsigned, std::uint64_t> http_responses; ///< by status
    std::uint64_t sessions_opened = 0;
    /// Never opened; by reason. From 0 on, as all that an alert may look at: the first one is seen as a rise.
    std::map<std::string, std::uint64_t, std::less<>> sessions_refused{
        {"address_full", 0}, {"bad_request", 0}, {"bad_upgrade", 0}, {"gave_way", 0},
        {"host", 0},         {"origin", 0},      {"server_full", 0}, {"shutting_down", 0},
        {"subprotocol", 0},  {"unauthorised", 0}};
    std::map<std::string, std::uint64_t, std::less<>> tokens_refused{
        {"in_the_clear", 0}, {"too_many_wrong", 0}, {"wrong", 0}};
    std::uint64_t reads_delayed = 0; ///< an address had sent too many bytes
    /// By reason; likewise.
    std::map<std::string, std::uint64_t, std::less<>> sessions_closed{{"bad_message", 0},
                                                                      {"bad_value", 0},
                                                                      {"closed_by_client", 0},
                                                                      {"disconnected", 0},
                                                                      {"dropped", 0},
                                                                      {"hello_expected", 0},
                                                                      {"idle", 0},
                                                                      {"internal", 0},
                                                                      {"shutting_down", 0},
                                                                      {"too_many_requests", 0},
                                                                      {"too_slow", 0},
                                                                      {"unauthorised", 0},
                                                                      {"unsupported_version", 0}};
    /// By error code; likewise.
    std::map<std::string, std::uint64_t, std::less<>> requests_refused{
        {"bad_value", 0},       {"internal", 0},          {"not_offered", 0}, {"too_large", 0},
        {"too_many_points", 0}, {"too_many_requests", 0}, {"unauthorised", 0}};
    std::uint64_t messages_received = 0;
    std::uint64_t bytes_received = 0;
    std::uint64_t messages_sent = 0;
    std::uint64_t bytes_sent = 0;
    std::uint64_t queries = 0;
    std::uint64_t query_points = 0;
    /// From when a query had been read until its reply was handed to its line: of few_points at most, and of more.
    Durations few_answered;
    Durations many_answered;
    std::uint64_t fetches = 0;
    std::uint64_t predictions_given_up = 0; ///< by sessions that now want the same whole
    std::uint64_t keyframes_published = 0;  ///< that somebody wanted
    std::uint64_t keyframes_dropped = 0;    ///< one a rung; encoder too far behind
    std::uint64_t keyframes_wrong = 0;      ///< refused by the codec: not finite
    std::uint64_t out_of_memory = 0;        ///< something was ended for want of it
    OutboxCounters outboxes;                ///< of sessions that have ended
};

/// Figures of the moment.
struct Gauges {
    std::size_t sessions = 0;
    std::size_t sessions_max = 0;
    std::size_t subscriptions = 0;
    std::size_t connections = 0;
    std::size_t outbox_bytes = 0;
    OutboxCounters outboxes; ///< of the sessions that live
};

/// Prometheus text, names seaway_net_*.
std::string metrics_text(const Counters& counters, const Gauges& gauges,
                         const EncoderCounters& encoder);

} // namespace seaway::server
