// SPDX-License-Identifier: Apache-2.0
// A disk that does not keep what it took: SQLite's call for it is this program's, which refuses when it is told to.
#include <atomic>
#include <cerrno>
#include <csignal>

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/journals.h"

namespace {

std::atomic<int> fail_next = 0;
std::atomic<int> failed = 0;

int synchronise(long call, int file) {
    if (fail_next > 0) {
        --fail_next;
        ++failed;
        errno = EIO;
        return -1;
    }
    return static_cast<int>(::syscall(call, file));
}

} // namespace

extern "C" __attribute__((visibility("default"))) int fdatasync(int file) {
    return synchronise(SYS_fdatasync, file);
}
extern "C" __attribute__((visibility("default"))) int fsync(int file) {
    return synchronise(SYS_fsync, file);
}

namespace seaway::server {
namespace {

using namespace tests_of_journals;

/// What a process that is killed right behind it says of a change for which the disk fails so many times.
struct Ended {
    bool refused = false;
    bool unknown = false;
    std::size_t held = 0; ///< changes, by who opens the journal next
};
Ended killed_behind_a_change(int failures) {
    const std::string folder = tests::folder().file(fmt::format("failing-{}", next_number()));
    int told[2];
    EXPECT_EQ(pipe(told), 0);
    const pid_t writer = fork();
    if (writer == 0) {
        auto journal = SqliteJournal::open(folder, beginning);
        const bool first = journal && (*journal)->append(change(2));
        fail_next = failures;
        const Result<void> kept = first ? (*journal)->append(change(3)) : Result<void>();
        const char says[] = {!kept, !kept && kept.error().is(JournalError::unknown),
                             failed == failures};
        if (::write(told[1], says, sizeof says) == sizeof says)
            ::kill(::getpid(), SIGKILL);
        _exit(1);
    }
    close(told[1]);
    char says[3] = {};
    EXPECT_EQ(read(told[0], says, sizeof says), 3);
    close(told[0]);
    int status = 0;
    waitpid(writer, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_TRUE(says[2]) << "the disk has not been asked";
    auto journal = SqliteJournal::open(folder, beginning);
    EXPECT_TRUE(journal) << journal.error().message;
    return {says[0] != 0, says[1] != 0, journal ? (*journal)->since(0)->size() : 0};
}

// Naive: the refused change stands whole in the log of the file, and the next process finds it there.
TEST(FailingDisk, a_change_that_was_refused_is_not_found_by_the_next_process_either) {
    const Ended ended = killed_behind_a_change(1);
    EXPECT_TRUE(ended.refused);
    EXPECT_FALSE(ended.unknown);
    EXPECT_EQ(ended.held, 2u);
}

TEST(FailingDisk, where_that_cannot_be_made_sure_of_the_change_may_have_been_made) {
    const Ended ended = killed_behind_a_change(2);
    EXPECT_TRUE(ended.refused);
    EXPECT_TRUE(ended.unknown);
}

} // namespace
} // namespace seaway::server
