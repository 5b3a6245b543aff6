// SPDX-License-Identifier: Apache-2.0
// A journal in one file of a folder, DIR/journal.sqlite: SQLite, write-ahead log, synchronous=FULL.
//
// The file comes into being whole, by a rename. So a file that is there is a journal, or it is named and left alone:
// one of another program, one that is damaged, one that a later version wrote. The folder is this process's while
// the journal is open (DIR/lock). Layout 1 did not say when a change was made: such a file is given that column before its next change.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>

#include "base/file_identity.h"
#include "base/folder_lock.h"
#include "server/journal/journal.h"

struct sqlite3;

namespace seaway::server {

class SqliteJournal final : public Journal {
  public:
    /// The folder is made where only it is missing. Errors name the folder, after the `option` that said so, or the file, and
    /// what to do.
    static Result<std::unique_ptr<SqliteJournal>> open(const std::string& folder,
                                                       const Beginning& beginning,
                                                       const std::string& option = "--data-dir");
    ~SqliteJournal() override = default;

    /// DIR/journal.sqlite.
    const std::string& name() const override { return path_; }
    std::int64_t epoch_utc_us() const override { return epoch_utc_us_; }
    using Journal::since;
    Result<std::vector<SeaChange>> since(std::uint32_t epoch, std::size_t most) const override;
    Result<void> append(const SeaChange& change) override;
    Result<void> note_begun(std::int64_t elapsed_us) override;
    JournalStanding standing() const override;
    std::int64_t spread_us() const override { return 0; }
    void compare_clocks(std::function<std::int64_t()> elapsed_us) override;
    void connect_no_more() override {}                     // it is a file
    void call_on_change(std::function<void()>) override {} // nobody else has the folder

  private:
    struct Close {
        void operator()(sqlite3* database) const;
    };
    using Database = std::unique_ptr<sqlite3, Close>;

    SqliteJournal(FolderLock lock, std::string path)
        : lock_(std::move(lock)), path_(std::move(path)) {}

    static Result<void> create(const std::string& folder, const std::string& path,
                               const Beginning& beginning);
    Result<void> open_file();
    Result<void> look_through();
    Result<void> read_when_made();
    Result<void> say_when_made();
    void empty_log();
    void is_written(std::int64_t now_utc_us);
    Result<void> check_there() const;
    void hold(const SeaChange& last);
    Result<void> check_clock(std::int64_t now_utc_us) const;
    Error wrong(const std::string& why) const;
    /// With the kind of `why`.
    Error not_opened(const Error& why, const std::string& what = {}) const;
    static Result<std::unique_ptr<SqliteJournal>>
    try_open(const std::string& folder, const Beginning& beginning, const std::string& option);
    Error undone(Error why);

    FolderLock lock_;
    std::string path_;
    std::optional<FileIdentity> file_;     ///< that was opened
    std::optional<FileIdentity> log_file_; ///< and what SQLite writes first, beside it
    mutable std::mutex mutex_;
    Database database_;
    mutable std::mutex reading_;
    Database reader_; ///< since() does not wait for append(), which waits for the disk
    std::int64_t epoch_utc_us_ = 0;
    SeaChange last_; ///< without its scene
    /// Its number, for whoever may not wait for a disk.
    std::atomic<std::uint32_t> last_epoch_ = 0;
    std::uint64_t sum_ = 0;                     ///< of all changes
    std::function<std::int64_t()> elapsed_us_;  ///< none: it is not said when changes are made
    std::atomic<std::int64_t> made_utc_us_ = 0; ///< JournalStanding
    bool says_when_made_ = true;                ///< the file is of layout 2
};

} // namespace seaway::server
