// SPDX-License-Identifier: Apache-2.0
#include "client/apps/ctl_status.h"

#include <cstdint>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace seaway::client {
namespace {

/// Changes that the log counts, of as many as it may; as a server without a journal, none.
std::string counted(const nlohmann::json& journal) {
    const int of = journal.value("counted_max", 0);
    return of > 0 ? fmt::format("{}/{}", journal.at("counted").get<int>(), of) : "-";
}

/// Of all sessions. A server of an earlier version says it of those alone that it lists.
std::uint64_t bytes_waiting(const nlohmann::json& sessions) {
    if (sessions.contains("bytes_waiting"))
        return sessions.at("bytes_waiting").get<std::uint64_t>();
    std::uint64_t bytes = 0;
    for (const nlohmann::json& one : sessions.at("listed"))
        bytes += one.at("bytes_waiting").get<std::uint64_t>();
    return bytes;
}

// By at(), which throws for what is not there.
std::string row_of(const std::string& url, const std::string& version, const nlohmann::json& state,
                   double cores, const nlohmann::json& sessions) {
    const nlohmann::json none = {
        {"shared", false},  {"changes", 1},          {"played", 1},
        {"peers", 0},       {"clock_ahead_ms", 0.0}, {"clock_error_ms", 0.0},
        {"unheard_s", 0.0}, {"stale", false},        {"why", ""}};
    const nlohmann::json journal = state.value("journal", none);
    return fmt::format(
        "{:<30} {:<22} {:<6} {:>7} {:>6} {:>9.3f} {:>9.3f} {:>6.2f} {:>5} {:>8} "
        "{:>6.2f} {:>9} {:>11} {}\n",
        url, version, journal.at("stale").get<bool>() ? "stale" : "ready",
        journal.at("changes").get<int>(),
        journal.at("changes").get<int>() - journal.at("played").get<int>(),
        journal.at("clock_ahead_ms").get<double>(), journal.at("clock_error_ms").get<double>(),
        journal.at("unheard_s").get<double>(), journal.at("peers").get<int>(),
        // This program is one of them.
        sessions.at("sessions").get<int>() - 1, cores, bytes_waiting(sessions) / 1024,
        counted(journal), journal.at("why").get<std::string>());
}

} // namespace

StatusRow status_row(const std::string& url, const std::string& version,
                     const std::string& state_before, const std::string& state, double between_s,
                     const std::string& sessions) {
    const nlohmann::json before = nlohmann::json::parse(state_before, nullptr, false);
    const nlohmann::json said = nlohmann::json::parse(state, nullptr, false);
    const nlohmann::json who = nlohmann::json::parse(sessions, nullptr, false);
    try {
        const bool stale = said.contains("journal") && said.at("journal").at("stale").get<bool>();
        const double took_s = said.at("cpu_s").get<double>() - before.at("cpu_s").get<double>();
        return {row_of(url, version, said, took_s / between_s, who), !stale};
    } catch (const nlohmann::json::exception&) { // of another version
        return {fmt::format("{:<30} says its state in other words than this program knows\n", url),
                false};
    }
}

} // namespace seaway::client
