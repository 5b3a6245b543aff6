// SPDX-License-Identifier: Apache-2.0
// A server whose patience is long, and who knocks at its door from several loopback addresses.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/net/net_fixture.h"

namespace seaway::tests {

inline constexpr const char* neighbour = "127.0.0.2";

class NetDoor : public NetTest {
  protected:
    NetDoor() {
        options.hello_deadline = std::chrono::minutes(5); // who is silent stays
        options.http_deadline = std::chrono::minutes(5);
    }
    void ask_for_tokens() {
        options.client_token_file = folder().write("door_client", "open sesame\n");
        options.admin_token_file = folder().write("door_admin", "master\n");
    }
    int status(const std::string& target, const std::string& token = {},
               const std::string& from = {}) {
        return ask_http(port(), target, "GET", token.empty() ? "" : "Bearer " + token, from).status;
    }
    /// What the server says at `target` with the right token.
    double counted(const std::string& name, const std::string& token = {}) {
        const int from = net->health_port() > 0 ? net->health_port() : port();
        const std::string bearing = token.empty() ? "" : "Bearer " + token;
        return figure_of(ask_http(from, "/metrics", "GET", bearing, "127.0.0.9").body, name);
    }
    /// 0: came in; else the code of the close, or the HTTP status that was no upgrade.
    unsigned knock(const std::string& token, const std::string& from = {},
                   const std::string& fields = {}) {
        Client client(port(), from);
        if (client.connect("seaway.v1", fields))
            return static_cast<unsigned>(client.status());
        return client.greet(token) ? 0u : client.close_code();
    }
    /// Again and again on one connection.
    static bool is_served(RawPeer& peer) {
        peer.say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
        return peer.header().find("200 OK") != std::string::npos;
    }
    std::vector<std::unique_ptr<RawPeer>> silent_crowd(int count) const {
        std::vector<std::unique_ptr<RawPeer>> crowd;
        for (int i = 0; i < count; ++i)
            crowd.push_back(std::make_unique<RawPeer>(port()));
        return crowd;
    }
    static std::string bearer(const std::string& token) {
        return "Authorization: Bearer " + token + "\r\n";
    }
};

} // namespace seaway::tests
