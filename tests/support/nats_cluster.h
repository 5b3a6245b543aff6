// SPDX-License-Identifier: Apache-2.0
// Three nats-servers with JetStream that are a cluster, each of which can die or be cut off from the two others. What one says
// to another goes through a FaultProxy for each direction in which it connects; those who use the log reach a node directly.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "tests/support/fault_proxy.h"
#include "tests/support/nats_server.h"

namespace seaway::tests {

class NatsCluster {
  public:
    static constexpr std::size_t size = 3;

    NatsCluster() {
        for (int& port : routes_)
            port = free_port();
        for (std::size_t from = 0; from < size; ++from)
            for (std::size_t to = 0; to < size; ++to)
                if (from != to)
                    lines_[from][to] = std::make_unique<FaultProxy>(routes_[to]);
        // Nodes tell of one another where each can be found: at a place that leads nowhere, for the lines are the only way.
        for (std::size_t i = 0; i < size; ++i)
            nodes_[i] = std::make_unique<NatsServer>(fmt::format(
                "server_name: node{}\n"
                "cluster {{ name: sea, listen: \"127.0.0.1:{}\", advertise: \"127.0.0.1:1\", "
                "routes: [\"nats://127.0.0.1:{}\", \"nats://127.0.0.1:{}\"] }}",
                i, routes_[i], line(i, (i + 1) % size).port(), line(i, (i + 2) % size).port()));
    }
    NatsServer& node(std::size_t i) { return *nodes_[i]; }
    std::string url(const std::string& world) const {
        return fmt::format("nats://127.0.0.1:{},127.0.0.1:{},127.0.0.1:{}/{}", nodes_[0]->port(),
                           nodes_[1]->port(), nodes_[2]->port(), world);
    }

    /// Nothing passes between this node and the others, and nobody is told; until join().
    void part(std::size_t i) { stall(i, true); }
    void join(std::size_t i) { stall(i, false); }
    /// Each way between any two of them.
    void delay(std::chrono::microseconds by) {
        for (auto& from : lines_)
            for (auto& one : from)
                if (one)
                    one->set({.delay = by});
    }
    /// That have passed between this node and the others.
    std::uint64_t bytes_between(std::size_t i) const {
        std::uint64_t bytes = 0;
        for (std::size_t other = 0; other < size; ++other)
            if (other != i)
                for (const FaultProxy* one : {&line(i, other), &line(other, i)})
                    bytes += one->bytes_carried(FaultProxy::Way::to_server) +
                             one->bytes_carried(FaultProxy::Way::to_client);
        return bytes;
    }

    /// Who leads a world's log, as node `asked` has it; `size`: nobody, or nobody says.
    std::size_t leader(const std::string& world, std::size_t asked) const {
        const std::string answer = nodes_[asked]->ask("$JS.API.STREAM.INFO.SEAWAY_" + world);
        for (std::size_t i = 0; i < size; ++i)
            if (answer.find(fmt::format("\"leader\":\"node{}\"", i)) != std::string::npos)
                return i;
        return size;
    }

    /// All nodes hold a world's log to its end, and who leads has heard of each.
    bool whole(const std::string& world) const {
        for (const auto& node : nodes_) {
            const std::string answer = node->ask("$JS.API.STREAM.INFO.SEAWAY_" + world);
            const std::size_t first = answer.find("\"current\":true");
            if (first != std::string::npos &&
                answer.find("\"current\":true", first + 1) != std::string::npos &&
                answer.find("\"offline\":true") == std::string::npos)
                return true;
        }
        return false;
    }

  private:
    FaultProxy& line(std::size_t from, std::size_t to) const { return *lines_[from][to]; }
    void stall(std::size_t i, bool stalled) {
        for (std::size_t other = 0; other < size; ++other)
            if (other != i) {
                line(i, other).stall(stalled);
                line(other, i).stall(stalled);
            }
    }

    std::array<int, size> routes_{};
    std::array<std::array<std::unique_ptr<FaultProxy>, size>, size> lines_; ///< from, to
    std::array<std::unique_ptr<NatsServer>, size> nodes_;
};

} // namespace seaway::tests
