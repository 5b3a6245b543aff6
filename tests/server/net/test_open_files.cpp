// SPDX-License-Identifier: Apache-2.0
// The limit on open files, in processes of their own: it is one of the whole process.
#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "server/net/open_files.h"

namespace seaway::server {
namespace {

void limit_files(rlim_t now, rlim_t most) {
    const rlimit files{now, most};
    if (setrlimit(RLIMIT_NOFILE, &files) != 0)
        std::_Exit(77);
}

TEST(OpenFilesDeathTest, the_limit_is_raised_as_far_as_it_goes) {
    EXPECT_EXIT(
        {
            limit_files(64, 200);
            NetOptions options;
            options.connections_max = 136;
            const bool fine = raise_open_files(options).has_value();
            rlimit files{};
            getrlimit(RLIMIT_NOFILE, &files);
            std::_Exit(fine && files.rlim_cur == 200 ? 0 : 1);
        },
        testing::ExitedWithCode(0), "");
}

// Naive: connections beyond the limit are accepted late, or never, and nothing says why.
TEST(OpenFilesDeathTest, too_few_for_the_connections_is_one_line_with_both_figures) {
    EXPECT_EXIT(
        {
            limit_files(64, 200);
            NetOptions options;
            options.connections_max = 130;
            options.health_listen = "127.0.0.1:0";
            options.health_connections_max = 7;
            const Result<void> raised = raise_open_files(options);
            std::fputs(raised ? "fine" : raised.error().message.c_str(), stderr);
            std::_Exit(raised ? 1 : 0);
        },
        testing::ExitedWithCode(0),
        "^--connections-max 130: 201 open files are needed and 200 are allowed; [^\n]*LimitNOFILE");
}

} // namespace
} // namespace seaway::server
