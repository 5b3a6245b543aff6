// SPDX-License-Identifier: Apache-2.0
// What Linux says of a process or a thread: /proc/*/status.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/types.h>

namespace seaway::tests {

/// The word behind a name, such as "SigBlk"; empty where there is none. `of`: a folder of /proc.
inline std::string status_of(const std::filesystem::path& of, const std::string& name) {
    std::ifstream status(of / "status");
    for (std::string word; status >> word;)
        if (word == name + ":" && status >> word)
            return word;
    return {};
}

/// One of its sets of signals, such as "SigBlk": bit n - 1 is signal n. None where there is none.
inline std::uint64_t signals_in(const std::filesystem::path& of, const std::string& set) {
    const std::string bits = status_of(of, set);
    return bits.empty() ? 0 : std::stoull(bits, nullptr, 16);
}

/// "VmRSS": that it has of the machine's memory; "VmSize": its addresses. 0: it has ended.
inline double memory_bytes(pid_t process, const std::string& kind = "VmRSS") {
    const std::string kib = status_of("/proc/" + std::to_string(process), kind);
    return kib.empty() ? 0 : 1024 * std::stod(kib);
}

} // namespace seaway::tests
