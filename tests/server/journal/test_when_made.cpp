// SPDX-License-Identifier: Apache-2.0
// A journal in a file knows when its last change was made, and takes none from a clock that is behind that.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include "server/journal/sea_clock.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/journals.h"
#include "tests/support/read_file.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;

std::unique_ptr<SqliteJournal> open(const std::string& folder, std::int64_t& elapsed_us) {
    auto journal = SqliteJournal::open(folder, beginning);
    EXPECT_TRUE(journal) << (journal ? "" : journal.error().message);
    if (!journal)
        return nullptr;
    (*journal)->compare_clocks([&elapsed_us] { return elapsed_us; });
    return *std::move(journal);
}

void run_sql(const std::string& path, const char* sql) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    char* why = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, &why), SQLITE_OK) << (why ? why : "");
    sqlite3_free(why);
    sqlite3_close(database);
}

// Naive: after a start whose clock is not set yet a change begins before those that ran, which then never have.
TEST(WhenMade, nothing_is_taken_while_the_clock_is_before_the_last_change) {
    const std::string folder = tests::folder().fresh("when-made");
    std::int64_t elapsed_us = 100'000'000;
    auto journal = open(folder, elapsed_us);
    ASSERT_TRUE(journal->append(change(2)));
    EXPECT_EQ(journal->standing().made_utc_us, beginning.epoch_utc_us + 100'000'000);
    for (const bool again : {false, true}) {
        if (again) {
            journal.reset();
            journal = open(folder, elapsed_us = 100'000'000);
        }
        elapsed_us -= 1;
        const Result<void> refused = journal->append(change(3));
        ASSERT_FALSE(refused) << again;
        EXPECT_TRUE(refused.error().is(JournalError::clock_behind)) << refused.error().message;
        EXPECT_NE(refused.error().message.find(utc_text(beginning.epoch_utc_us + 100'000'000)),
                  std::string::npos)
            << refused.error().message;
        EXPECT_EQ(journal->since(0).value().size(), 2u);
    }
    elapsed_us += 1;
    EXPECT_TRUE(journal->append(change(3))) << "at that moment it may";
}

// Naive: the last change is of long ago, and what a timetable has brought since is taken over from by a clock that is behind it.
TEST(WhenMade, nothing_is_taken_while_the_clock_is_before_the_last_sea_that_began) {
    const std::string folder = tests::folder().fresh("when-begun");
    std::int64_t elapsed_us = 100'000'000;
    auto journal = open(folder, elapsed_us);
    ASSERT_TRUE(journal->append(change(2)));
    ASSERT_TRUE(journal->note_begun(900'000'000));
    for (const bool again : {false, true}) {
        if (again) {
            journal.reset();
            journal = open(folder, elapsed_us);
        }
        EXPECT_EQ(journal->standing().made_utc_us, beginning.epoch_utc_us + 900'000'000);
        EXPECT_EQ(journal->since(0).value().size(), 2u) << "and no change";
        elapsed_us = 899'999'999;
        EXPECT_TRUE(journal->note_begun(elapsed_us)) << "nothing new";
        const Result<void> refused = journal->append(change(3));
        ASSERT_FALSE(refused) << again;
        EXPECT_TRUE(refused.error().is(JournalError::clock_behind)) << refused.error().message;
    }
    elapsed_us = 900'000'000;
    EXPECT_TRUE(journal->append(change(3)));
}

// Files of layout 1 did not say it.
TEST(WhenMade, a_file_that_did_not_say_is_read_and_says_so_from_the_next_change_on) {
    const std::string folder = tests::folder().fresh("when-made");
    std::int64_t elapsed_us = 100'000'000;
    ASSERT_TRUE(open(folder, elapsed_us)->append(change(2)));
    const std::string path = folder + "/journal.sqlite";
    run_sql(path, "ALTER TABLE changes DROP COLUMN made_utc_us; PRAGMA user_version = 1;"
                  "PRAGMA wal_checkpoint(TRUNCATE)");
    const std::string before = tests::read_file(path);
    ASSERT_EQ(before[63], 1);
    EXPECT_TRUE(open(folder, elapsed_us)->note_begun(200'000'000));
    EXPECT_EQ(tests::read_file(path), before)
        << "who only looks leaves it to the version that wrote it";
    elapsed_us = 5;
    for (std::uint32_t number = 3; number <= 4; ++number) {
        const auto journal = open(folder, elapsed_us);
        ASSERT_TRUE(journal);
        EXPECT_EQ(journal->since(0).value().size(), number - 1);
        EXPECT_TRUE(journal->append(change(number))) << "nobody knows when the one before was made";
        EXPECT_EQ(journal->standing().made_utc_us, beginning.epoch_utc_us + 5);
        EXPECT_EQ(tests::read_file(path)[63], 2) << "while it is open, too";
    }
    elapsed_us = 4;
    EXPECT_FALSE(open(folder, elapsed_us)->append(change(5)));
}

} // namespace
} // namespace seaway::server
