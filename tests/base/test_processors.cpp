// SPDX-License-Identifier: Apache-2.0
#include "base/processors.h"

#include <fstream>
#include <sched.h>
#include <thread>

#include <gtest/gtest.h>

#include "base/thread_pool.h"
#include "tests/support/folder.h"

namespace seaway {
namespace {

TEST(Processors, a_quota_is_rounded_up_and_max_is_none) {
    EXPECT_EQ(processors_of_quota("200000 100000"), 2);
    EXPECT_EQ(processors_of_quota("150000 100000\n"), 2);
    EXPECT_EQ(processors_of_quota("1000 100000"), 1);
    EXPECT_EQ(processors_of_quota("9223372036854775807 1"), 1 << 20);
    for (const char* none : {"max 100000", "", "200000", "200000 ", "0 100000", "-1 100000",
                             "200000 0", "2e5 100000", "200000\t100000", "99999999999999999999 1"})
        EXPECT_EQ(processors_of_quota(none), std::nullopt) << none;
}

/// Groups as a container sees them: a limit may stand at any of those above it.
TEST(Processors, the_narrowest_group_counts) {
    tests::Folder& folder = tests::folder();
    const std::filesystem::path groups = folder.file("groups");
    std::filesystem::remove_all(groups);
    std::filesystem::create_directories(groups / "pods" / "sea");
    const auto limit = [&](const std::filesystem::path& group, const char* text) {
        std::ofstream(groups / group / "cpu.max") << text << '\n';
    };
    const auto usable = [&](const char* own) {
        std::ofstream(folder.file("own")) << own;
        return usable_processors(groups, folder.file("own"));
    };
    const int all = usable("0::/pods/sea\n");
    EXPECT_GE(all, 1);
    limit("pods/sea", "max 100000");
    EXPECT_EQ(usable("0::/pods/sea\n"), all);
    limit("pods", "100000 100000");
    EXPECT_EQ(usable("1:cpu:/\n0::/pods/sea\n"), 1) << "of the group above";
    EXPECT_EQ(usable("0::/\n"), all);
    EXPECT_EQ(usable(""), all) << "no group of the second kind";
    EXPECT_EQ(usable("0::/gone/away\n"), all);
    limit("", "50000 100000");
    EXPECT_EQ(usable("0::/gone/away\n"), 1) << "half a processor is one";
}

TEST(Processors, a_pool_has_no_more_threads_than_affinity_leaves) {
    int usable = 0;
    int pool = 0;
    std::thread bound([&] {
        cpu_set_t first;
        ASSERT_EQ(::sched_getaffinity(0, sizeof first, &first), 0);
        int cpu = 0;
        while (!CPU_ISSET(cpu, &first))
            ++cpu;
        CPU_ZERO(&first);
        CPU_SET(cpu, &first);
        ASSERT_EQ(::sched_setaffinity(0, sizeof first, &first), 0);
        usable = usable_processors();
        pool = ThreadPool().threads();
    });
    bound.join();
    EXPECT_EQ(usable, 1);
    EXPECT_EQ(pool, 1);
}

} // namespace
} // namespace seaway
