// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/journals.h"
#include "tests/support/full_disk.h"
#include "tests/support/read_file.h"

namespace seaway::server {
namespace {

namespace fs = std::filesystem;

using namespace tests_of_journals;

/// A new folder, which is not there yet.
std::string fresh_folder() {
    return tests::folder().fresh("journal");
}

void write(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

std::string error_of(const std::string& folder) {
    const auto opened = SqliteJournal::open(folder, beginning);
    return opened ? "it was opened" : opened.error().message;
}

// Naive: what is written to a file that has no name any more is acknowledged, and no restart finds it.
TEST(SqliteJournal, keeps_nothing_in_a_file_that_was_removed_or_replaced) {
    const std::string folder = fresh_folder(), kept = fresh_folder();
    auto journal = SqliteJournal::open(folder, beginning).value();
    ASSERT_TRUE(journal->append(change(2)));
    fs::rename(folder, kept);
    const auto refused = journal->append(change(3));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("was removed or replaced"), std::string::npos)
        << refused.error().message;
    fs::create_directory(folder);
    fs::copy(kept, folder); // as a backup that is put back
    EXPECT_FALSE(journal->append(change(3)));
    fs::remove_all(folder);
    fs::rename(kept, folder);
    EXPECT_TRUE(journal->append(change(3))) << "it is there again";
    EXPECT_EQ(journal->since(0).value().size(), 3u);
}

// Naive: SQLite writes on to the log of the file that has no name any more, and it is acknowledged.
TEST(SqliteJournal, keeps_nothing_in_a_log_that_was_removed_from_beside_it) {
    const std::string folder = fresh_folder();
    auto journal = SqliteJournal::open(folder, beginning).value();
    ASSERT_TRUE(journal->append(change(2)));
    ASSERT_TRUE(fs::remove(folder + "/journal.sqlite-wal"));
    const auto refused = journal->append(change(3));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("was removed or replaced"), std::string::npos)
        << refused.error().message;
}

// Who looks at it with another program lets go again: that is no wrong journal.
TEST(SqliteJournal, that_another_program_holds_passes) {
    const std::string folder = fresh_folder();
    ASSERT_TRUE(SqliteJournal::open(folder, beginning).value()->append(change(2)));
    sqlite3* other = nullptr;
    ASSERT_EQ(sqlite3_open((folder + "/journal.sqlite").c_str(), &other), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(other,
                           "PRAGMA locking_mode = EXCLUSIVE; BEGIN IMMEDIATE; "
                           "UPDATE sea SET epoch_utc_us = epoch_utc_us; COMMIT",
                           nullptr, nullptr, nullptr),
              SQLITE_OK);
    const auto opened = SqliteJournal::open(folder, beginning);
    ASSERT_FALSE(opened);
    EXPECT_TRUE(opened.error().is(JournalError::unreachable)) << opened.error().message;
    EXPECT_EQ(opened.error().message.find("damaged"), std::string::npos) << opened.error().message;
    sqlite3_close(other);
    EXPECT_TRUE(SqliteJournal::open(folder, beginning));
}

// A disk that has no room for the files beside it, which are made by whoever opens it: another start may find some.
TEST(SqliteJournal, on_a_full_disk_is_no_wrong_one) {
    const std::string folder = fresh_folder(), fresh = fresh_folder();
    ASSERT_TRUE(SqliteJournal::open(folder, beginning).value()->append(change(2)));
    for (const std::string& place : {folder, fresh}) {
        const auto opened =
            tests::on_full_disk(1000, [&] { return SqliteJournal::open(place, beginning); });
        ASSERT_FALSE(opened);
        EXPECT_TRUE(opened.error().is(JournalError::unreachable)) << opened.error().message;
    }
    EXPECT_EQ(SqliteJournal::open(folder, beginning).value()->since(0).value().size(), 2u);
}

TEST(SqliteJournal, is_of_one_process_at_a_time) {
    const std::string folder = fresh_folder();
    auto first = SqliteJournal::open(folder, beginning).value();
    EXPECT_EQ(error_of(folder), fmt::format("--data-dir {}: another process works in it", folder));
    first.reset();
    EXPECT_EQ(error_of(folder), "it was opened");
}

TEST(SqliteJournal, names_a_file_of_others_and_leaves_it_as_it_is) {
    struct Case {
        const char* what;
        std::string bytes;
        const char* says;
    };
    auto made = SqliteJournal::open(fresh_folder(), beginning).value();
    std::string foreign = tests::read_file(made->name()), later = foreign;
    foreign[71] ^=
        1; // application_id ends at byte 71, user_version at 63 (sqlite.org/fileformat2.html)
    later[63] = 3;
    const Case cases[] = {{"empty", "", "is no journal"},
                          {"text", std::string(5000, 'a'), "is no journal"},
                          {"a name alone", "SQLite format 3", "is no journal"},
                          {"of another program", foreign, "belongs to another program"},
                          {"of a later version", later, "by another version of Seaway"}};
    for (const Case& c : cases) {
        const std::string folder = fresh_folder(), path = folder + "/journal.sqlite";
        fs::create_directory(folder);
        write(path, c.bytes);
        const std::string error = error_of(folder);
        EXPECT_NE(error.find(path), std::string::npos) << error;
        EXPECT_NE(error.find(c.says), std::string::npos) << c.what << ": " << error;
        EXPECT_NE(error.find("left as it is"), std::string::npos) << error;
        EXPECT_EQ(tests::read_file(path), c.bytes) << c.what;
    }
}

TEST(SqliteJournal, names_what_is_no_folder_and_no_file) {
    const std::string file = tests::folder().write("a-file", "x");
    EXPECT_NE(error_of(file).find("--data-dir " + file), std::string::npos) << error_of(file);
    const std::string deep = fresh_folder() + "/not/there";
    EXPECT_NE(error_of(deep).find("--data-dir " + deep), std::string::npos) << error_of(deep);
    const std::string folder = fresh_folder();
    fs::create_directories(folder + "/journal.sqlite");
    EXPECT_NE(error_of(folder).find("journal.sqlite: "), std::string::npos) << error_of(folder);
    EXPECT_TRUE(fs::is_directory(folder + "/journal.sqlite"));
}

TEST(SqliteJournal, takes_nothing_that_lies_beside_a_journal_that_is_gone) {
    for (const char* part : {"-wal", "-shm", "-journal"}) {
        const std::string folder = fresh_folder(), rest = folder + "/journal.sqlite" + part;
        fs::create_directory(folder);
        write(rest, "of another sea");
        const std::string error = error_of(folder);
        EXPECT_NE(error.find(std::string("its journal.sqlite") + part + " is there"),
                  std::string::npos)
            << error;
        EXPECT_EQ(tests::read_file(rest), "of another sea");
        EXPECT_FALSE(fs::exists(folder + "/journal.sqlite"));
    }
}

TEST(SqliteJournal, is_no_link_to_that_of_another_folder) {
    const std::string folder = fresh_folder(), other = fresh_folder();
    EXPECT_EQ(error_of(folder), "it was opened");
    fs::create_directory(other);
    fs::create_symlink(folder + "/journal.sqlite", other + "/journal.sqlite");
    EXPECT_NE(error_of(other).find("is a link"), std::string::npos) << error_of(other);
}

/// A journal with `changes` of them, as it lies there after a crash: main file and write-ahead log, which another program that reads
/// has kept from being emptied.
std::string crashed_folder(std::uint32_t changes) {
    const std::string folder = fresh_folder(), copy = fresh_folder();
    auto journal = SqliteJournal::open(folder, beginning).value();
    sqlite3* reader = nullptr;
    EXPECT_EQ(sqlite3_open((folder + "/journal.sqlite").c_str(), &reader), SQLITE_OK);
    EXPECT_EQ(
        sqlite3_exec(reader, "BEGIN; SELECT count(*) FROM changes", nullptr, nullptr, nullptr),
        SQLITE_OK);
    for (std::uint32_t epoch = 2; epoch <= changes; ++epoch)
        EXPECT_TRUE(journal->append(change(epoch)));
    fs::create_directory(copy);
    for (const char* part : {"", "-wal"})
        fs::copy_file(folder + "/journal.sqlite" + part, copy + "/journal.sqlite" + part);
    sqlite3_close(reader);
    return copy;
}

// SQLite takes a log up to the last frame whose checksum is right; what was acknowledged had been synchronised, so only
// a change that nobody was told of can be cut.
TEST(SqliteJournal, cut_off_in_its_last_write_it_holds_all_changes_before) {
    const std::string crashed = crashed_folder(4), wal = crashed + "/journal.sqlite-wal";
    const std::string whole = tests::read_file(wal);
    std::size_t most = 0, least = 9;
    for (std::size_t cut = 0; cut <= whole.size(); cut += 509) {
        const std::string folder = fresh_folder();
        fs::copy(crashed, folder);
        write(folder + "/journal.sqlite-wal", whole.substr(0, cut));
        auto journal = SqliteJournal::open(folder, beginning);
        ASSERT_TRUE(journal) << "cut at " << cut << ": " << journal.error().message;
        const std::vector<SeaChange> held = (*journal)->since(0).value();
        ASSERT_FALSE(held.empty());
        EXPECT_EQ(held[0].scene, beginning.scene);
        for (std::size_t i = 1; i < held.size(); ++i)
            EXPECT_EQ(held[i], change(static_cast<std::uint32_t>(i) + 1));
        most = std::max(most, held.size());
        least = std::min(least, held.size());
        EXPECT_TRUE((*journal)->append(change(static_cast<std::uint32_t>(held.size()) + 1)));
    }
    EXPECT_EQ(least, 1u);
    EXPECT_GE(most, 3u);
}

// Naive: acknowledged changes stay in the log, where damage to one ends what SQLite takes of all that follow, without a word.
TEST(SqliteJournal, an_acknowledged_change_does_not_hang_on_its_log) {
    const std::string folder = fresh_folder();
    auto journal = SqliteJournal::open(folder, beginning).value();
    for (std::uint32_t epoch = 2; epoch <= 6; ++epoch)
        ASSERT_TRUE(journal->append(change(epoch)));
    for (const std::string& log : {std::string(), std::string(20'000, 'x'), std::string("gone")}) {
        const std::string crashed = fresh_folder(); // a process that was killed leaves both
        fs::create_directory(crashed);
        fs::copy_file(folder + "/journal.sqlite", crashed + "/journal.sqlite");
        if (log != "gone")
            write(crashed + "/journal.sqlite-wal", log);
        auto again = SqliteJournal::open(crashed, beginning);
        ASSERT_TRUE(again) << again.error().message;
        EXPECT_EQ((*again)->since(0).value().size(), 6u) << log.size();
    }
}

TEST(SqliteJournal, damaged_or_cut_off_it_is_named_and_left_as_it_is) {
    const std::string healthy = fresh_folder();
    {
        auto journal =
            SqliteJournal::open(healthy, {beginning.epoch_utc_us, std::string(20'000, 's')})
                .value();
        ASSERT_TRUE(journal->append(change(2)));
    }
    const std::string whole = tests::read_file(healthy + "/journal.sqlite");
    ASSERT_GT(whole.size(), 5u * 4096);
    const auto expect_named = [](const std::string& bytes, const std::string& what) {
        const std::string folder = fresh_folder(), path = folder + "/journal.sqlite";
        fs::create_directory(folder);
        write(path, bytes);
        const std::string error = error_of(folder);
        EXPECT_EQ(error.find(path), 0u) << what << ": " << error;
        EXPECT_EQ(tests::read_file(path), bytes) << what;
    };
    for (std::size_t cut = 50; cut < whole.size(); cut += 4096 - 7)
        expect_named(whole.substr(0, cut), fmt::format("cut at {}", cut));
    // A page of another kind, a tree that points nowhere, no sea, no change: the file is whole, what it says is not.
    for (const std::size_t page : {1u, 2u}) {
        std::string torn = whole;
        std::fill_n(torn.begin() + static_cast<std::ptrdiff_t>(page * 4096), 4096, '\0');
        expect_named(torn, fmt::format("page {} is gone", page + 1));
    }
    // The instant is another by a microsecond: every change hangs on it.
    std::string moved = whole;
    std::string instant;
    for (int shift = 56; shift >= 0; shift -= 8)
        instant += static_cast<char>(beginning.epoch_utc_us >> shift);
    const std::size_t at = moved.find(instant);
    ASSERT_NE(at, std::string::npos);
    moved[at + 7] ^= 1;
    expect_named(moved, "the instant is another");
}

// The thread that serves everybody asks how it stands: it may not wait for a disk, nor for who has the file open by hand.
TEST(SqliteJournal, says_how_it_stands_while_a_change_waits_for_the_file) {
    auto journal = SqliteJournal::open(fresh_folder(), beginning).value();
    sqlite3* by_hand = nullptr;
    ASSERT_EQ(sqlite3_open(journal->name().c_str(), &by_hand), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(by_hand, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
    std::atomic<bool> written = false;
    Result<void> append;
    std::thread writer([&] {
        append = journal->append(change(2));
        written = true;
    });
    // It is asked again and again while the writer comes to the file and waits there, seconds if it must.
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(300);
    while (std::chrono::steady_clock::now() < end) {
        EXPECT_EQ(journal->standing().last_epoch, 1u);
        EXPECT_EQ(journal->since(0)->size(), 1u) << "as an administrator's history asks";
    }
    EXPECT_FALSE(written);
    ASSERT_EQ(sqlite3_exec(by_hand, "ROLLBACK", nullptr, nullptr, nullptr), SQLITE_OK);
    writer.join();
    sqlite3_close(by_hand);
    EXPECT_TRUE(append) << append.error().message;
    EXPECT_EQ(journal->standing().last_epoch, 2u);
    EXPECT_EQ(journal->since(0)->size(), 2u);
}

// Killed anywhere between nothing and a journal that is there: the next start makes one, or takes that one.
TEST(SqliteJournal, killed_while_it_is_made_it_is_made_the_next_time) {
    // Later and later, until some came before it was there and some after, however busy the machine is.
    int made_before = 0, rounds = 0;
    for (int round = 0; round < 60 || (made_before == 0 && round < 600); ++round, ++rounds) {
        const std::string folder = fresh_folder();
        const pid_t maker = fork();
        if (maker == 0) {
            const auto journal = SqliteJournal::open(folder, beginning);
            pause();
        }
        usleep(static_cast<useconds_t>(round < 60 ? round * 50 : (round - 59) * 1000));
        kill(maker, SIGKILL);
        waitpid(maker, nullptr, 0);
        made_before += fs::exists(folder + "/journal.sqlite");
        auto journal = SqliteJournal::open(folder, {5, beginning.scene});
        ASSERT_TRUE(journal) << "round " << round << ": " << journal.error().message;
        EXPECT_EQ((*journal)->since(0)->size(), 1u);
        EXPECT_TRUE((*journal)->append(change(2)));
    }
    EXPECT_GT(made_before, 0);
    EXPECT_LT(made_before, rounds);
}

// A writer that is killed at any instant, twenty times over: what was acknowledged is there, at most the one that was
// being written besides, and the next writer goes on.
TEST(SqliteJournal, a_killed_writer_loses_nothing_that_it_was_told_is_kept) {
    const std::string folder = fresh_folder();
    std::mt19937 random(20);
    std::uint32_t acknowledged = 1;
    // However little a round comes to on a busy machine.
    for (int round = 0; round < 20 || (acknowledged <= 20 && round < 400); ++round) {
        int told[2];
        ASSERT_EQ(pipe(told), 0);
        const pid_t writer = fork();
        if (writer == 0) {
            auto journal = SqliteJournal::open(folder, beginning);
            for (auto epoch = journal ? (*journal)->since(0)->back().epoch + 1 : 0; epoch > 0;) {
                if (!(*journal)->append(change(epoch)) ||
                    ::write(told[1], &epoch, sizeof epoch) != sizeof epoch)
                    break;
                ++epoch;
            }
            _exit(1);
        }
        close(told[1]);
        // From before the file is there to some dozen changes later.
        usleep(random() % (round % 4 == 0 ? 3'000 : 60'000));
        kill(writer, SIGKILL);
        int status = 0;
        waitpid(writer, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status)) << "the writer gave up";
        std::uint32_t epoch = 0;
        while (read(told[0], &epoch, sizeof epoch) == sizeof epoch)
            acknowledged = epoch;
        close(told[0]);
        auto journal = SqliteJournal::open(folder, beginning);
        ASSERT_TRUE(journal) << journal.error().message;
        const std::vector<SeaChange> held = (*journal)->since(0).value();
        ASSERT_GE(held.size(), acknowledged);
        ASSERT_LE(held.size(), acknowledged + 1);
        for (std::size_t i = 1; i < held.size(); ++i)
            ASSERT_EQ(held[i], change(static_cast<std::uint32_t>(i) + 1));
        acknowledged = static_cast<std::uint32_t>(held.size());
    }
    EXPECT_GT(acknowledged, 20u) << "hardly anything was written";
}

} // namespace
} // namespace seaway::server
