// SPDX-License-Identifier: Apache-2.0
// The net's part of /metrics: each line shows its own figure, and each figure is what happened.
#include "protocol/limits.h"
#include "server/net/core.h"
#include "tests/server/net/net_fixture.h"
#include "tests/support/metrics_page.h"

namespace seaway::tests {
namespace {

using server::Counters;
using server::EncoderCounters;
using server::Gauges;
using wire::Body;

const std::map<std::string, double> figures{
    {"seaway_net_sessions", 2},
    {"seaway_net_sessions_max", 263},
    {"seaway_net_subscriptions", 3},
    {"seaway_net_connections", 5},
    {"seaway_net_outbox_bytes", 7},
    {"seaway_net_connections_accepted_total", 101},
    {"seaway_net_connections_refused_total{reason=\"server_full\"}", 103},
    {"seaway_net_connections_given_up_total", 107},
    {"seaway_net_handshakes_failed_total", 109},
    {"seaway_net_http_responses_total{status=\"200\"}", 113},
    {"seaway_net_http_responses_total{status=\"404\"}", 127},
    {"seaway_net_sessions_opened_total", 131},
    {"seaway_net_sessions_refused_total{reason=\"origin\"}", 223},
    {"seaway_net_tokens_refused_total{reason=\"wrong\"}", 227},
    {"seaway_net_reads_delayed_total", 229},
    {"seaway_net_sessions_closed_total{reason=\"idle\"}", 137},
    {"seaway_net_sessions_closed_total{reason=\"too_slow\"}", 139},
    {"seaway_net_requests_refused_total{code=\"bad_value\"}", 149},
    {"seaway_net_messages_received_total", 151},
    {"seaway_net_received_bytes_total", 157},
    {"seaway_net_messages_sent_total", 163},
    {"seaway_net_sent_bytes_total", 167},
    {"seaway_net_queries_total", 173},
    {"seaway_net_query_points_total", 179},
    {"seaway_net_fetches_total", 181},
    {"seaway_net_predictions_given_up_total", 997},
    {"seaway_net_keyframes_published_total", 191},
    {"seaway_net_keyframes_dropped_total", 193},
    {"seaway_net_keyframes_wrong_total", 197},
    {"seaway_net_out_of_memory_total", 257},
    // Of the sessions that have ended and of those that live.
    {"seaway_net_keyframes_sent_total", 1011},
    {"seaway_net_keyframes_predicted_total", 4019},
    {"seaway_net_keyframes_replaced_total", 2013},
    {"seaway_net_keyframes_awaiting_credit_total", 3017},
    {"seaway_net_fields_encoded_total", 211},
    {"seaway_net_fields_predicted_total", 269},
    {"seaway_net_fields_reused_total", 239},
    {"seaway_net_encoded_samples_total", 241},
    {"seaway_net_encoded_bytes_total", 251},
    {"seaway_net_encode_seconds_total", 0.25}};

/// The rows of the histogram of answers, which go from the page.
std::map<std::string, double> take_answers(MetricsPage& page) {
    const std::string name = "seaway_net_answer_seconds";
    std::map<std::string, double> rows;
    for (const auto& [row, value] : page.values)
        if (row.starts_with(name))
            rows[row.substr(name.size())] = value;
    std::erase_if(page.values, [&](const auto& row) { return row.first.starts_with(name); });
    return rows;
}

// No two figures are equal.

TEST(NetMetricsText, every_line_shows_the_figure_that_it_names) {
    const Counters counters{.connections_accepted = 101,
                            .connections_refused = {{"server_full", 103}},
                            .connections_given_up = 107,
                            .handshakes_failed = 109,
                            .http_responses = {{200, 113}, {404, 127}},
                            .sessions_opened = 131,
                            .sessions_refused = {{"origin", 223}},
                            .tokens_refused = {{"wrong", 227}},
                            .reads_delayed = 229,
                            .sessions_closed = {{"idle", 137}, {"too_slow", 139}},
                            .requests_refused = {{"bad_value", 149}},
                            .messages_received = 151,
                            .bytes_received = 157,
                            .messages_sent = 163,
                            .bytes_sent = 167,
                            .queries = 173,
                            .query_points = 179,
                            .fetches = 181,
                            .predictions_given_up = 997,
                            .keyframes_published = 191,
                            .keyframes_dropped = 193,
                            .keyframes_wrong = 197,
                            .out_of_memory = 257,
                            .outboxes = {1000, 4000, 2000, 3000}};
    const Gauges gauges{.sessions = 2,
                        .sessions_max = 263,
                        .subscriptions = 3,
                        .connections = 5,
                        .outbox_bytes = 7,
                        .outboxes = {11, 19, 13, 17}};
    const EncoderCounters encoder{.fields_encoded = 211,
                                  .fields_reused = 239,
                                  .fields_predicted = 269,
                                  .samples = 241,
                                  .bytes = 251,
                                  .seconds = 0.25};
    MetricsPage page = read_metrics(server::metrics_text(counters, gauges, encoder));
    (void)take_answers(page);
    expect_metrics(page, figures);
}

// By the rules of Prometheus: each bucket holds those of all before it, a bound is within its own.
TEST(NetMetricsText, durations_are_histograms_of_few_points_and_of_many) {
    Counters counters;
    for (const double seconds : {0.00015, 0.0005, 0.0004, 0.9, 5.0})
        counters.few_answered.add(seconds);
    counters.many_answered.add(0.03);
    MetricsPage page = read_metrics(server::metrics_text(counters, {}, {}));
    EXPECT_EQ(page.types["seaway_net_answer_seconds"], "histogram");
    const std::map<std::string, double> rows = take_answers(page);
    const auto within = [&](const std::string& points, const std::string& bound) {
        const auto row = rows.find("_bucket{points=\"" + points + "\",le=\"" + bound + "\"}");
        return row == rows.end() ? -1 : row->second;
    };
    const std::map<std::string, double> few{
        {"0.0001", 0}, {"0.0002", 1}, {"0.0005", 3}, {"0.001", 3}, {"0.002", 3},
        {"0.005", 3},  {"0.01", 3},   {"0.02", 3},   {"0.05", 3},  {"0.1", 3},
        {"0.2", 3},    {"1", 4},      {"+Inf", 5}};
    for (const auto& [bound, count] : few) {
        EXPECT_EQ(within("few", bound), count) << bound;
        EXPECT_EQ(within("many", bound), bound == "+Inf" || std::stod(bound) >= 0.05) << bound;
    }
    EXPECT_EQ(rows.at("_count{points=\"few\"}"), 5);
    EXPECT_NEAR(rows.at("_sum{points=\"few\"}"), 5.90105, 1e-9);
    EXPECT_EQ(rows.size(), 2 * (few.size() + 2));
}

class NetMetrics : public NetTest {
  protected:
    MetricsPage page() { return read_metrics(get("/metrics").body); }
    /// Four ask for pages, one says garbage, one is rude, one is lost: so many connections.
    double strangers() {
        double connections = 0;
        for (const auto& [target, method] : {std::pair("/healthz", "GET"),
                                             {"/healthz", "HEAD"},
                                             {"/none", "GET"},
                                             {"/", "POST"}}) {
            get(target, method);
            ++connections;
        }
        {
            RawPeer garbage(port());
            garbage.say("\x01\x02\r\n\r\n");
            EXPECT_NE(garbage.rest().find(" 400 "), std::string::npos);
            Client rude(port());
            EXPECT_FALSE(rude.connect());
            EXPECT_FALSE(rude.send(protocol::ping(1, 2))); // before Hello
            EXPECT_NE(rude.close_code(), 0u);
            RawPeer lost(port());
            lost.upgrade();
            lost.reset();
            connections += 3;
        }
        return connections;
    }
    /// Two queries and two requests that are refused.
    void asks(Client& client) {
        const std::vector<sea::QueryPoint> points(protocol::limits::points_per_query_max + 1);
        for (const std::size_t count : {2, 3}) {
            ASSERT_FALSE(client.send(protocol::query(1, std::span(points).first(count), false)));
            ASSERT_TRUE(client.receive(Body::QueryReply));
        }
        ASSERT_FALSE(client.send(protocol::query(2, points, false)));
        ASSERT_TRUE(client.receive(Body::Refused));
        const sea::TimeUs time_us = 0;
        ASSERT_FALSE(
            client.send(protocol::fetch(3, {&time_us, 1}, {.fields = {sea::Field::slope_x}})));
        ASSERT_TRUE(client.receive(Body::Refused));
    }
    /// The first page with so many sessions and connections: those that go are gone a moment later.
    MetricsPage page_with(double sessions, double connections) {
        MetricsPage shown;
        EXPECT_TRUE(eventually([&] {
            shown = page();
            return shown.values["seaway_net_sessions"] == sessions &&
                   shown.values["seaway_net_connections"] == connections;
        }));
        return shown;
    }
    bool settles(const std::string& name, double value) {
        return eventually([&] { return page().values[name] == value; });
    }
};

/// After the day below, but for what depends on how often the page was looked at.
const std::map<std::string, double> happened{
    {"seaway_net_sessions", 1},
    {"seaway_net_sessions_max", 1024},
    {"seaway_net_subscriptions", 1},
    {"seaway_net_connections", 2},
    {"seaway_net_outbox_bytes", 0},
    {"seaway_net_connections_refused_total{reason=\"address_full\"}", 0},
    {"seaway_net_connections_refused_total{reason=\"server_full\"}", 0},
    {"seaway_net_tokens_refused_total{reason=\"in_the_clear\"}", 0},
    {"seaway_net_tokens_refused_total{reason=\"too_many_wrong\"}", 0},
    {"seaway_net_tokens_refused_total{reason=\"wrong\"}", 0},
    {"seaway_net_connections_given_up_total", 0},
    {"seaway_net_reads_delayed_total", 0},
    {"seaway_net_handshakes_failed_total", 1},
    {"seaway_net_http_responses_total{status=\"404\"}", 1},
    {"seaway_net_http_responses_total{status=\"405\"}", 1},
    {"seaway_net_http_responses_total{status=\"400\"}", 1},
    {"seaway_net_sessions_opened_total", 3},
    {"seaway_net_sessions_closed_total{reason=\"hello_expected\"}", 1},
    {"seaway_net_sessions_closed_total{reason=\"disconnected\"}", 1},
    {"seaway_net_sessions_closed_total{reason=\"bad_message\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"bad_value\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"closed_by_client\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"dropped\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"idle\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"internal\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"shutting_down\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"too_many_requests\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"too_slow\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"unauthorised\"}", 0},
    {"seaway_net_sessions_closed_total{reason=\"unsupported_version\"}", 0},
    {"seaway_net_requests_refused_total{code=\"too_many_points\"}", 1},
    {"seaway_net_requests_refused_total{code=\"not_offered\"}", 1},
    {"seaway_net_requests_refused_total{code=\"bad_value\"}", 0},
    {"seaway_net_requests_refused_total{code=\"internal\"}", 0},
    {"seaway_net_requests_refused_total{code=\"too_large\"}", 0},
    {"seaway_net_requests_refused_total{code=\"too_many_requests\"}", 0},
    {"seaway_net_requests_refused_total{code=\"unauthorised\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"address_full\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"bad_request\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"bad_upgrade\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"gave_way\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"host\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"origin\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"server_full\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"shutting_down\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"subprotocol\"}", 0},
    {"seaway_net_sessions_refused_total{reason=\"unauthorised\"}", 0},
    {"seaway_net_messages_received_total", 9}, // the rude ping and eight of the session
    // Welcome, state, 2 replies, 2 refusals, 2 tiles and done, grant, 4 tiles and done, 2 tiles; and to the rude ping a GoAway.
    {"seaway_net_messages_sent_total", 18},
    {"seaway_net_queries_total", 2},
    {"seaway_net_query_points_total", 5},
    {"seaway_net_fetches_total", 3},
    {"seaway_net_predictions_given_up_total", 0},
    {"seaway_net_keyframes_published_total", 3},
    {"seaway_net_keyframes_dropped_total", 0},
    {"seaway_net_keyframes_wrong_total", 0},
    {"seaway_net_out_of_memory_total", 0},
    {"seaway_net_keyframes_sent_total", 2},
    {"seaway_net_keyframes_predicted_total", 0},
    {"seaway_net_keyframes_replaced_total", 1},
    {"seaway_net_keyframes_awaiting_credit_total", 2},
    {"seaway_net_fields_encoded_total", 7},
    {"seaway_net_fields_predicted_total", 0},
    {"seaway_net_fields_reused_total", 2},
    {"seaway_net_encoded_samples_total", 7 * 32 * 32}};

// A known day of a server, and the whole page after it. The page knows itself as a connection, but not
// yet as a response.
TEST_F(NetMetrics, the_whole_page_adds_up_to_what_happened) {
    start();
    const double connections = strangers() + 1;
    const std::unique_ptr<Client> client = greeted(); // is sent a Welcome and a sea state
    asks(*client);
    const sea::TimeUs time_us = 0;
    const sea::FieldSet height{sea::Field::height};
    // Keyframes 0 and 1 of one cascade, then of both: two of the four are known already.
    ASSERT_FALSE(
        client->send(protocol::fetch(4, {&time_us, 1}, {.cascades = 2u, .fields = height})));
    ASSERT_TRUE(client->receive(Body::FetchDone));
    ASSERT_FALSE(client->send(protocol::subscribe(5, {.cascades = 3u, .fields = height}, 1)));
    ASSERT_TRUE(client->receive(Body::FetchDone));
    // One credit: the keyframe of the first cascade is sent, that of the second waits for an Ack, is
    // replaced once and then sent.
    net->publish(host.keyframe(0, 5, height));
    ASSERT_TRUE(client->receive(Body::Tile)); // before the next one comes, the credit is used
    net->publish(host.keyframe(1, 5, height));
    ASSERT_TRUE(settles("seaway_net_keyframes_published_total", 2));
    net->publish(host.keyframe(1, 6, height));
    ASSERT_TRUE(settles("seaway_net_keyframes_published_total", 3));
    MetricsPage waiting = page();
    EXPECT_GT(waiting.values["seaway_net_outbox_bytes"], 0);
    const auto numbers = [&] { // of the last one received
        const wire::Message* message = client->receive();
        return message && message->body_as_Tile() ? message->body_as_Tile()->time_us() : -1;
    };
    ASSERT_FALSE(client->send(protocol::ack(5))); // the fifth keyframe that was encoded
    EXPECT_EQ(numbers(), 6 * interval_us);

    // What the waiting took is not known; what it left behind is.
    MetricsPage last = page_with(1, 2);
    const double own = last.values["seaway_net_connections_accepted_total"] - connections;
    EXPECT_GT(own, 0);
    EXPECT_EQ(last.values["seaway_net_http_responses_total{status=\"200\"}"], 2 + own - 1);
    for (const char* name : {"seaway_net_connections_accepted_total",
                             "seaway_net_http_responses_total{status=\"200\"}",
                             "seaway_net_received_bytes_total", "seaway_net_sent_bytes_total",
                             "seaway_net_encoded_bytes_total", "seaway_net_encode_seconds_total"}) {
        EXPECT_GT(last.values[name], 0) << name;
        last.values.erase(name);
    }
    const std::map<std::string, double> answers = take_answers(last);
    EXPECT_EQ(answers.at("_count{points=\"few\"}"), 2) << "queries of 2 and 3 points";
    EXPECT_EQ(answers.at("_count{points=\"many\"}"), 0);
    EXPECT_GT(answers.at("_sum{points=\"few\"}"), 0);
    last.values.erase("seaway_simulation_up"); // of the host
    EXPECT_EQ(last.values["seaway_memory_budget_bytes"], 640.0 * 1024 * 1024);
    EXPECT_GT(last.values["seaway_memory_held_bytes{of=\"encoded\"}"], 0);
    std::erase_if(last.values,
                  [](const auto& row) { return row.first.starts_with("seaway_memory_"); });
    expect_metrics(last, happened);
}

// Naive: what a session did is forgotten with it, and a counter falls.
TEST_F(NetMetrics, counters_never_fall_and_gauges_come_back_when_a_session_ends) {
    start();
    const sea::FieldSet height{sea::Field::height};
    std::unique_ptr<Client> clients[2];
    for (auto& client : clients) {
        client = greeted();
        ASSERT_FALSE(client->send(protocol::subscribe(1, {.cascades = 1u, .fields = height}, 1)));
        ASSERT_TRUE(client->receive(Body::FetchDone));
    }
    for (const std::int64_t n : {5, 6, 7}) { // the first is sent, one waits, one replaces it
        net->publish(host.keyframe(0, n, height));
        ASSERT_TRUE(settles("seaway_net_keyframes_published_total", static_cast<double>(n - 4)));
        for (const auto& client : clients)
            if (n == 5) {
                ASSERT_TRUE(client->receive(Body::Tile));
            }
    }
    const auto counts = [&](const MetricsPage& shown) {
        return std::vector<double>{shown.values.at("seaway_net_keyframes_sent_total"),
                                   shown.values.at("seaway_net_keyframes_replaced_total"),
                                   shown.values.at("seaway_net_keyframes_awaiting_credit_total")};
    };
    const std::vector<double> both{2, 2, 4};
    EXPECT_EQ(counts(page()), both);
    const double bytes_of_two = page().values["seaway_net_outbox_bytes"];
    EXPECT_GT(bytes_of_two, 0);
    clients[1] = nullptr;
    ASSERT_TRUE(settles("seaway_net_sessions", 1));
    EXPECT_EQ(page().values["seaway_net_outbox_bytes"], bytes_of_two / 2) << "equal sessions";
    EXPECT_EQ(counts(page()), both);
    clients[0] = nullptr;
    const MetricsPage last = page_with(0, 1);
    EXPECT_EQ(counts(last), both);
    EXPECT_EQ(last.values.at("seaway_net_outbox_bytes"), 0);
    EXPECT_EQ(last.values.at("seaway_net_subscriptions"), 0);
    EXPECT_EQ(last.values.at("seaway_net_connections"), 1) << "the one that asks";
}

// Of a burst of lines within a second of the clock as many are written as may be; the rest is said in
// numbers once there is room again. Where a burst falls into two seconds it is made again.
TEST(NetLog, a_flood_is_cut_at_its_limit_and_what_was_left_out_is_counted) {
    const auto second_now = [] {
        return std::chrono::duration_cast<std::chrono::seconds>(
                   std::chrono::steady_clock::now().time_since_epoch())
            .count();
    };
    SmallSea host;
    constexpr int most = server::Core::log_lines_per_second_max;
    bool measured = false;
    for (int attempt = 0; attempt < 20 && !measured; ++attempt) {
        const LogCapture log;
        server::Core core({}, host, nullptr);
        const auto begun = second_now();
        for (int i = 0; i < most + 7; ++i)
            core.log("event=flood");
        measured = second_now() == begun;
        if (!measured)
            continue;
        EXPECT_EQ(log.lines_with("event=flood").size(), static_cast<std::size_t>(most));
        ASSERT_TRUE(eventually([&] { return second_now() != begun; }));
        core.log("event=after");
        core.log("event=after");
        EXPECT_EQ(log.lines_with("event=after").size(), 2u);
        EXPECT_EQ(log.lines_with("event=log_lines_left_out", "count=7").size(), 1u) << log.text();
        EXPECT_EQ(log.lines_with("event=log_lines_left_out").size(), 1u) << "once";
    }
    EXPECT_TRUE(measured);
}

} // namespace
} // namespace seaway::tests
