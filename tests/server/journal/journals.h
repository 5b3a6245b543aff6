// SPDX-License-Identifier: Apache-2.0
// What the tests of journals share: a beginning, changes, and both kinds of journals at places of their own.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "server/journal/nats_log.h"
#include "server/journal/open_journal.h"
#include "tests/support/folder.h"
#include "tests/support/nats_server.h"

namespace seaway::server::tests_of_journals {

inline const Beginning beginning{1'700'000'000'123'456, "[sea]\nseed = 7\n"};

inline SeaChange change(std::uint32_t epoch) {
    const sea::TimeUs start_us = 1'000'000 * static_cast<sea::TimeUs>(epoch);
    return {epoch, start_us, start_us + 500'000, fmt::format("sea {}", epoch)};
}

/// One for all tests of a process that do not stop it.
inline tests::NatsServer& nats() {
    static tests::NatsServer server;
    return server;
}

inline int next_number() {
    static int count = 0;
    return ++count;
}

/// Places where there is no journal yet.
struct InAFolder {
    static JournalPlace fresh() { return {.where = tests::folder().fresh("any-journal")}; }
};
struct InNats {
    static JournalPlace fresh() {
        return {.where = nats().url(fmt::format("world-{}", next_number()))};
    }
};

inline std::string fresh_world() {
    return fmt::format("nats-world-{}", next_number());
}

inline std::unique_ptr<Journal> open_at(const std::string& url, const Beginning& with = beginning) {
    Result<std::unique_ptr<Journal>> journal = open_journal({.where = url}, with);
    EXPECT_TRUE(journal) << (journal ? "" : journal.error().message);
    return journal ? *std::move(journal) : nullptr;
}

inline std::string error_at(const JournalPlace& place) {
    const auto journal = open_journal(place, beginning);
    return journal ? "it was opened" : journal.error().message;
}

inline NatsLog log_of(const std::string& url) {
    return NatsLog(NatsConnection::make(read_nats_url(url).value()).value());
}

} // namespace seaway::server::tests_of_journals
