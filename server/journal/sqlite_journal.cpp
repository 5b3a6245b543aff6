// SPDX-License-Identifier: Apache-2.0
#include "server/journal/sqlite_journal.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include <fmt/format.h>
#include <sqlite3.h>

#include "base/disk_room.h"
#include "base/text_file.h"
#include "server/journal/change_text.h"
#include "server/journal/journal_file.h"
#include "server/journal/sea_clock.h"
#include "server/journal/sqlite_statement.h"

namespace seaway::server {
namespace {

constexpr int busy_wait_ms = 5000; ///< for who looks at the file with another program

constexpr const char* layout = R"(
    PRAGMA application_id = 1399153015;
    PRAGMA user_version = 2;
    CREATE TABLE sea (one INTEGER PRIMARY KEY CHECK (one = 1), epoch_utc_us INTEGER NOT NULL) STRICT;
    CREATE TABLE changes (
        epoch INTEGER PRIMARY KEY,
        start_us INTEGER NOT NULL,
        end_us INTEGER NOT NULL,
        scene TEXT NOT NULL,
        sum INTEGER NOT NULL,
        made_utc_us INTEGER) STRICT;
)";
static_assert(journal_application_id == 1399153015 && journal_version == 2, "as the layout says");
/// What layout 1 lacks. The header of a file may still say 1 when what stands beside it says 2.
constexpr const char* when_last_made = "SELECT max(made_utc_us) FROM changes";
constexpr const char* note_last_made = "UPDATE changes SET made_utc_us = ? WHERE epoch = ?";
constexpr const char* add_when_made =
    "BEGIN IMMEDIATE; ALTER TABLE changes ADD COLUMN made_utc_us INTEGER; "
    "PRAGMA user_version = 2; COMMIT";

Result<void> insert(sqlite3* database, const SeaChange& change, std::uint64_t sum,
                    std::int64_t made_utc_us) {
    SEAWAY_TRY_LET(Statement row,
                   Statement::prepare(database,
                                      "INSERT INTO changes (epoch, start_us, end_us, scene, "
                                      "sum, made_utc_us) VALUES (?, ?, ?, ?, ?, ?)"));
    row.bind(change.epoch).bind(change.start_us).bind(change.end_us).bind(text_of(change));
    row.bind(static_cast<std::int64_t>(sum)).bind(made_utc_us);
    SEAWAY_TRY(row.step());
    return {};
}

std::string parent_of(const std::string& folder) {
    const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
    return (whole.has_filename() ? whole : whole.parent_path()).parent_path().string();
}

} // namespace

void SqliteJournal::Close::operator()(sqlite3* database) const {
    sqlite3_close_v2(database);
}

Error SqliteJournal::wrong(const std::string& why) const {
    return Error{fmt::format("{}: {}", path_, why)};
}

Error SqliteJournal::not_opened(const Error& why, const std::string& what) const {
    Error error = wrong(what + why.message);
    error.kind = why.kind;
    return error;
}

Result<std::unique_ptr<SqliteJournal>> SqliteJournal::open(const std::string& folder,
                                                           const Beginning& beginning,
                                                           const std::string& option) {
    auto opened = try_open(folder, beginning, option);
    if (opened || !is_disk_full(folder))
        return opened;
    Error error = opened.error();
    error.kind = JournalError::unreachable;
    error.message += "; the disk is full";
    return error;
}

Result<std::unique_ptr<SqliteJournal>> SqliteJournal::try_open(const std::string& folder,
                                                               const Beginning& beginning,
                                                               const std::string& option) {
    const auto named = [&folder, &option](const Error& why) {
        return Error{fmt::format("{} {}: {}", option, folder, why.message)};
    };
    std::error_code error;
    if (const bool made = std::filesystem::create_directory(folder, error); error)
        return named({error.message()});
    else if (made)
        if (const Result<void> kept = sync_folder(parent_of(folder)); !kept)
            return named(kept.error());
    Result<FolderLock> lock = FolderLock::take(folder);
    if (!lock)
        return named(lock.error());
    std::unique_ptr<SqliteJournal> journal(
        new SqliteJournal(std::move(*lock), folder + "/journal.sqlite"));
    const bool there = std::filesystem::symlink_status(journal->path_, error).type() !=
                       std::filesystem::file_type::not_found;
    if (!there)
        if (const Result<void> alone = check_no_rest(journal->path_); !alone)
            return journal->wrong(alone.error().message);
    if (!there)
        if (const Result<void> made = create(folder, journal->path_, beginning); !made)
            return journal->not_opened(made.error(), "cannot be made: ");
    if (const Result<void> fine = check_journal_header(journal->path_); !fine)
        return journal->not_opened(fine.error());
    if (const Result<void> opened = journal->open_file(); !opened)
        return journal->not_opened(opened.error());
    journal->file_ = file_identity(journal->path_);
    journal->log_file_ = file_identity(journal->path_ + "-wal");
    return journal;
}

/// Under another name until it is whole. What an interrupted start has left under that name was never told anybody.
Result<void> SqliteJournal::create(const std::string& folder, const std::string& path,
                                   const Beginning& beginning) {
    const std::string fresh = path + ".new";
    SEAWAY_TRY(check_replaceable(fresh));
    std::error_code error;
    for (const char* part : {"", "-journal", "-wal", "-shm"})
        std::filesystem::remove(fresh + part, error);
    sqlite3* opened = nullptr;
    const int code = sqlite3_open_v2(fresh.c_str(), &opened,
                                     SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    Database database(opened);
    if (code != SQLITE_OK)
        return sql_error(opened);
    SEAWAY_TRY(run(opened, "PRAGMA synchronous = FULL; BEGIN IMMEDIATE"));
    SEAWAY_TRY(run(opened, layout));
    {
        SEAWAY_TRY_LET(Statement sea, Statement::prepare(opened, "INSERT INTO sea VALUES (1, ?)"));
        SEAWAY_TRY(sea.bind(beginning.epoch_utc_us).step());
    }
    const SeaChange first{.scene = beginning.scene};
    SEAWAY_TRY(insert(opened, first, sum_of(first_sum(beginning.epoch_utc_us), first), 0));
    SEAWAY_TRY(run(opened, "COMMIT; PRAGMA journal_mode = WAL"));
    if (sqlite3_close(database.release()) != SQLITE_OK) // the log is in the file now, and gone
        return Error{"it cannot be closed"};
    std::filesystem::rename(fresh, path, error);
    if (error)
        return Error{error.message()};
    return sync_folder(folder);
}

Result<void> SqliteJournal::open_file() {
    sqlite3* opened = nullptr;
    const int code = sqlite3_open_v2(path_.c_str(), &opened,
                                     SQLITE_OPEN_READWRITE | SQLITE_OPEN_FULLMUTEX, nullptr);
    database_.reset(opened);
    if (code != SQLITE_OK)
        return sql_error(opened);
    sqlite3_busy_timeout(opened, busy_wait_ms);
    if (sqlite3_db_readonly(opened, "main") != 0)
        return Error{"cannot be written"};
    // Nothing of it changes, not even where it is closed again, before it has been found whole.
    sqlite3_db_config(opened, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
    SEAWAY_TRY(look_through());
    sqlite3_db_config(opened, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 0, nullptr);
    SEAWAY_TRY(run(opened, "PRAGMA synchronous = FULL"));
    {
        SEAWAY_TRY_LET(Statement mode, Statement::prepare(opened, "PRAGMA journal_mode = WAL"));
        SEAWAY_TRY_LET(const bool row, mode.step());
        if (!row || mode.text(0) != "wal")
            return Error{"cannot be written with a log ahead: " + mode.text(0)};
    }
    // What passes is met by the next change.
    if (const Result<void> writes = run(opened, "BEGIN IMMEDIATE; ROLLBACK");
        !writes && !writes.error().is(JournalError::unreachable)) {
        Error error = writes.error();
        error.message += ": who may write it, what lies beside it (-wal, -shm) and its folder?";
        return error;
    }
    SEAWAY_TRY(read_when_made());
    sqlite3* reader = nullptr;
    const int read = sqlite3_open_v2(path_.c_str(), &reader,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_FULLMUTEX, nullptr);
    reader_.reset(reader);
    if (read != SQLITE_OK)
        return sql_error(reader);
    sqlite3_busy_timeout(reader, busy_wait_ms);
    return {};
}

Result<void> SqliteJournal::look_through() {
    // What passes is no damage, wherever it comes between.
    const auto is_damaged = [](const Error& how) {
        return how.is(JournalError::unreachable)
                   ? how
                   : Error{fmt::format("is damaged ({}); it is left as it is", how.message)};
    };
    SEAWAY_TRY_LET(Statement check, Statement::prepare(database_.get(), "PRAGMA quick_check(1)"));
    const Result<bool> checked = check.step();
    if (!checked)
        return is_damaged(checked.error());
    if (!*checked || check.text(0) != "ok")
        return is_damaged(Error{check.text(0)});
    Result<Statement> sea = Statement::prepare(database_.get(), "SELECT epoch_utc_us FROM sea");
    if (!sea)
        return is_damaged(sea.error());
    const Result<bool> has_sea = sea->step();
    if (!has_sea)
        return is_damaged(has_sea.error());
    if (!*has_sea)
        return is_damaged(Error{"it does not say when the sea began"});
    epoch_utc_us_ = sea->integer(0);
    if (const Result<void> epoch = check_epoch(epoch_utc_us_); !epoch)
        return is_damaged(epoch.error());
    const Result<std::vector<SeaChange>> changes = since(0);
    if (!changes)
        return is_damaged(changes.error());
    if (changes->empty() || changes->front().epoch != 1 || changes->front().start_us != 0)
        return is_damaged(Error{"it does not hold the sea that it began with"});
    SeaChange last{.epoch = 0};
    sum_ = first_sum(epoch_utc_us_);
    Result<Statement> sums =
        Statement::prepare(database_.get(), "SELECT sum FROM changes ORDER BY epoch");
    for (const SeaChange& change : *changes) {
        if (const Result<void> next = check_next(last, change); !next)
            return is_damaged(next.error());
        sum_ = sum_of(sum_, change);
        const Result<bool> row = sums ? sums->step() : Result<bool>(sums.error());
        if (!row)
            return is_damaged(row.error());
        if (!*row || static_cast<std::uint64_t>(sums->integer(0)) != sum_)
            return is_damaged(
                Error{fmt::format("the change of epoch {} is not what was written", change.epoch)});
        last = change;
    }
    hold(last);
    return {};
}

Result<void> SqliteJournal::read_when_made() {
    SEAWAY_TRY_LET(const std::int64_t says, first_number(database_.get(), "PRAGMA user_version"));
    if ((says_when_made_ = says == journal_version)) {
        SEAWAY_TRY_LET(made_utc_us_, first_number(database_.get(), when_last_made));
    }
    return {};
}

/// Into the file itself, so that an earlier version names it instead of failing at its next change.
Result<void> SqliteJournal::say_when_made() {
    if (says_when_made_)
        return {};
    SEAWAY_TRY(run(database_.get(), add_when_made));
    says_when_made_ = true;
    empty_log();
    return {};
}

/// Into the file itself, where damage is found: of the log SQLite takes what is whole and passes over the rest. Where another program
/// reads, the next change does, or the end.
void SqliteJournal::empty_log() {
    sqlite3_busy_timeout(database_.get(), 0); // nobody waits for who reads
    (void)run(database_.get(), "PRAGMA wal_checkpoint(TRUNCATE)");
    sqlite3_busy_timeout(database_.get(), busy_wait_ms);
}

void SqliteJournal::hold(const SeaChange& last) {
    last_ = {last.epoch, last.start_us, last.end_us, {}};
    last_epoch_ = last.epoch;
}

Result<std::vector<SeaChange>> SqliteJournal::since(std::uint32_t epoch, std::size_t most) const {
    const std::scoped_lock lock(reading_);
    sqlite3* database =
        (reader_ ? reader_ : database_).get(); // until it is found whole there is one
    SEAWAY_TRY_LET(Statement rows,
                   Statement::prepare(database, "SELECT epoch, start_us, end_us, scene FROM "
                                                "changes WHERE epoch > ? ORDER BY epoch LIMIT ?"));
    rows.bind(epoch).bind(static_cast<std::int64_t>(most));
    std::vector<SeaChange> changes;
    while (true) {
        SEAWAY_TRY_LET(const bool row, rows.step());
        if (!row)
            return changes;
        SEAWAY_TRY_LET(
            SeaChange change,
            with_text(
                {static_cast<std::uint32_t>(rows.integer(0)), rows.integer(1), rows.integer(2), {}},
                rows.text(3)));
        changes.push_back(std::move(change));
    }
}

/// What was written whole before the disk failed to keep it stands in the log of the file, and would be found there by who
/// opens it after this process was killed. So it is written over; where that fails, too, nobody knows.
Error SqliteJournal::undone(Error why) {
    const int code = sqlite3_extended_errcode(database_.get());
    if ((code & 0xff) != SQLITE_IOERR || code == SQLITE_IOERR_WRITE) // before it was whole
        return why;
    // Twice: a value that stays as it was is not written.
    const Result<void> over =
        run(database_.get(), "BEGIN IMMEDIATE; UPDATE sea SET epoch_utc_us = ~epoch_utc_us; "
                             "UPDATE sea SET epoch_utc_us = ~epoch_utc_us; COMMIT");
    if (!over) {
        (void)run(database_.get(),
                  "ROLLBACK"); // an error where it has been, which no one need hear
        why.kind = JournalError::unknown;
    }
    return why;
}

/// Of a clock that has not been set yet, as after a start: a change made by it would begin before those that have run.
Result<void> SqliteJournal::check_clock(std::int64_t now_utc_us) const {
    if (now_utc_us >= made_utc_us_)
        return {};
    return Error{
        JournalError::clock_behind,
        wrong(fmt::format("takes nothing: its last change was made, or its sea begun, at {}, and "
                          "by the sea's clock it is {}. Set this machine's clock",
                          utc_text(made_utc_us_), utc_text(now_utc_us)))
            .message};
}

void SqliteJournal::compare_clocks(std::function<std::int64_t()> elapsed_us) {
    const std::scoped_lock lock(mutex_);
    elapsed_us_ = std::move(elapsed_us);
}

void SqliteJournal::is_written(std::int64_t now_utc_us) {
    log_file_ = log_file_ ? log_file_ : file_identity(path_ + "-wal");
    made_utc_us_ = now_utc_us;
    empty_log();
}

/// What is written to a file that is gone nobody would find.
Result<void> SqliteJournal::check_there() const {
    if (file_identity(path_) == file_ && (!log_file_ || file_identity(path_ + "-wal") == log_file_))
        return {};
    return wrong("was removed or replaced while this server runs: a restart goes on with what is "
                 "there then");
}

/// Beside the last change: none is made before it anyway. A file of layout 1 stays one until it is changed.
Result<void> SqliteJournal::note_begun(std::int64_t elapsed_us) {
    const std::scoped_lock lock(mutex_);
    const std::int64_t begun_us = epoch_utc_us_ + elapsed_us;
    if (!says_when_made_ || begun_us <= made_utc_us_)
        return {};
    SEAWAY_TRY(check_there());
    SEAWAY_TRY_LET(Statement noted, Statement::prepare(database_.get(), note_last_made));
    SEAWAY_TRY(noted.bind(begun_us).bind(last_epoch_).step());
    is_written(begun_us);
    return {};
}

Result<void> SqliteJournal::append(const SeaChange& change) {
    const std::scoped_lock lock(mutex_);
    const std::int64_t made_us = elapsed_us_ ? epoch_utc_us_ + elapsed_us_() : made_utc_us_.load();
    SEAWAY_TRY(check_clock(made_us));
    if (const Result<void> next = check_next(last_, change); !next)
        return wrong(next.error().message);
    SEAWAY_TRY(check_there());
    const std::uint64_t sum = sum_of(sum_, change);
    const Result<void> says = say_when_made();
    const Result<void> written = says ? insert(database_.get(), change, sum, made_us) : says;
    if (!written)
        return undone(wrong(written.error().message));
    sum_ = sum;
    hold(change);
    is_written(made_us);
    return {};
}

JournalStanding SqliteJournal::standing() const {
    return {.last_epoch = last_epoch_, .peers = {}, .made_utc_us = made_utc_us_, .trouble = {}};
}

} // namespace seaway::server
