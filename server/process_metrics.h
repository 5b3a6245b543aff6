// SPDX-License-Identifier: Apache-2.0
// What this process takes of its machine, under the names that Prometheus gives it for every program
// (prometheus.io/docs/instrumenting/writing_clientlibs, "process metrics"). Linux: /proc/self.
#pragma once

#include <filesystem>
#include <string>

namespace seaway::server {

/// Prometheus text: processor time, resident memory, open files and how many there may be. What cannot be read in the
/// folder of the process is left out.
std::string process_metrics_text(const std::filesystem::path& process = "/proc/self");

} // namespace seaway::server
