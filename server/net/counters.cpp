// SPDX-License-Identifier: Apache-2.0
#include "server/net/counters.h"

#include <fmt/format.h>

#include "server/host/metrics_text.h"

namespace seaway::server {
namespace {

/// Histograms of one name, by a label.
template <class Map>
void add_durations(MetricsText& t, std::string_view name, std::string_view label,
                   std::string_view help, const Map& values) {
    t.family(name, "histogram", help);
    for (const auto& [key, value] : values) {
        std::uint64_t within = 0;
        for (std::size_t i = 0; i < Durations::bounds_s.size(); ++i)
            t.value({{label, key}, {"le", fmt::format("{:g}", Durations::bounds_s[i])}},
                    within += value.within[i], "_bucket");
        t.value({{label, key}, {"le", "+Inf"}}, value.count, "_bucket");
        t.value({{label, key}}, value.sum_s, "_sum");
        t.value({{label, key}}, value.count, "_count");
    }
}

/// From the simulation to the sessions.
void add_keyframes(MetricsText& t, const Counters& c, const Gauges& g, const EncoderCounters& e) {
    t.one("keyframes_published_total", "counter", "Keyframes that somebody wanted",
          c.keyframes_published);
    t.one("keyframes_dropped_total", "counter",
          "Keyframes left out before encoding, one a rung: the encoder is behind",
          c.keyframes_dropped);
    t.one("keyframes_wrong_total", "counter", "Keyframes with samples that were not finite",
          c.keyframes_wrong);
    t.one("out_of_memory_total", "counter", "Connections and messages ended for want of memory",
          c.out_of_memory);
    t.one("keyframes_sent_total", "counter", "Keyframes streamed, summed over sessions",
          c.outboxes.keyframes_started + g.outboxes.keyframes_started);
    t.one("keyframes_predicted_total", "counter",
          "Keyframes of those streamed that were differences to what was sent before",
          c.outboxes.keyframes_predicted + g.outboxes.keyframes_predicted);
    t.one("keyframes_replaced_total", "counter", "Keyframes that a newer one replaced",
          c.outboxes.keyframes_replaced + g.outboxes.keyframes_replaced);
    t.one("keyframes_awaiting_credit_total", "counter", "Keyframes that waited for an Ack",
          c.outboxes.keyframes_awaiting_credit + g.outboxes.keyframes_awaiting_credit);
    t.one("fields_encoded_total", "counter", "Fields encoded", e.fields_encoded);
    t.one("fields_predicted_total", "counter", "Fields encoded as differences, too",
          e.fields_predicted);
    t.one("fields_reused_total", "counter", "Fields served from the encoder's memory",
          e.fields_reused);
    t.one("encoded_samples_total", "counter", "Samples encoded", e.samples);
    t.one("encoded_bytes_total", "counter", "Bytes of the tile messages made", e.bytes);
    t.one("encode_seconds_total", "counter", "Time spent encoding", e.seconds);
}

} // namespace

std::string metrics_text(const Counters& c, const Gauges& g, const EncoderCounters& e) {
    MetricsText t("seaway_net_");
    t.one("sessions", "gauge", "WebSocket sessions open", g.sessions);
    t.one("sessions_max", "gauge", "As many are taken at a time", g.sessions_max);
    t.one("subscriptions", "gauge", "Sessions that are streamed tiles", g.subscriptions);
    t.one("connections", "gauge", "Connections open, HTTP and WebSocket", g.connections);
    t.one("outbox_bytes", "gauge", "Bytes that wait in all outboxes; shared bytes count again",
          g.outbox_bytes);
    t.one("connections_accepted_total", "counter", "Connections taken", c.connections_accepted);
    t.each("connections_refused_total", "reason", "Connections above a limit, closed at once",
           c.connections_refused);
    t.one("connections_given_up_total", "counter",
          "Connections without a whole request that made room for a newcomer",
          c.connections_given_up);
    t.one("handshakes_failed_total", "counter", "Connections that spoke no TLS, HTTP or WebSocket",
          c.handshakes_failed);
    t.each("http_responses_total", "status", "HTTP responses", c.http_responses);
    t.one("sessions_opened_total", "counter", "WebSocket sessions", c.sessions_opened);
    t.each("sessions_refused_total", "reason", "Upgrades that did not become a session",
           c.sessions_refused);
    t.each("tokens_refused_total", "reason", "Tokens that were not taken", c.tokens_refused);
    t.one("reads_delayed_total", "counter",
          "Requests read later because their address had sent too many bytes", c.reads_delayed);
    t.each("sessions_closed_total", "reason", "WebSocket sessions that ended", c.sessions_closed);
    t.each("requests_refused_total", "code", "Requests refused", c.requests_refused);
    t.one("messages_received_total", "counter", "Messages from clients", c.messages_received);
    t.one("received_bytes_total", "counter", "Bytes of messages from clients", c.bytes_received);
    t.one("messages_sent_total", "counter", "Messages to clients", c.messages_sent);
    t.one("sent_bytes_total", "counter", "Bytes of messages to clients", c.bytes_sent);
    t.one("queries_total", "counter", "Queries accepted", c.queries);
    t.one("query_points_total", "counter", "Points of queries accepted", c.query_points);
    add_durations(t, "answer_seconds", "points",
                  "From when a query has been read until its reply is handed to its line",
                  std::map<std::string, const Durations&>{{"few", c.few_answered},
                                                          {"many", c.many_answered}});
    t.one("fetches_total", "counter", "Fetches and starts of subscriptions", c.fetches);
    t.one("predictions_given_up_total", "counter",
          "Sessions that could not follow predicted keyframes and asked for whole ones",
          c.predictions_given_up);
    add_keyframes(t, c, g, e);
    return t.take();
}

} // namespace seaway::server
