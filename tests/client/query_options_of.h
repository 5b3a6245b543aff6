// SPDX-License-Identifier: Apache-2.0
// Options as seaway-query reads them from a command line.
#pragma once

#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "client/apps/query_options.h"

namespace seaway::client {

/// What is printed of those that are refused is not shown.
inline std::variant<QueryOptions, int> query_options_of(std::vector<const char*> words) {
    words.insert(words.begin(), "seaway-query");
    ::testing::internal::CaptureStderr();
    auto read = read_query_options(static_cast<int>(words.size()), words.data());
    ::testing::internal::GetCapturedStderr();
    return read;
}

} // namespace seaway::client
