// SPDX-License-Identifier: Apache-2.0
// A journal that several servers follow: the messages of a SharedLog, change n in message n.
//
// What has been read is held, so since() asks nobody. poll() asks the log where it ends and reads what is new; a thread does so four
// times a second if it is asked to follow. While the log cannot be asked the journal holds what it held, says for how long
// (standing()), and takes no change. What the log holds is checked before it is held: a message that is foreign, damaged, of
// another version or of another chain is named, and nothing behind it is taken; a log that is shorter than it was, or another
// one, likewise. Nothing is ever overwritten: a change is appended where the log ends, or not at all.
//
// Thread-safe. Holds all changes, some 3 KB each.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/journal/change_text.h"
#include "server/journal/journal.h"
#include "server/journal/peer_line.h"
#include "server/journal/shared_log.h"

namespace seaway::server {

class SharedJournal final : public Journal {
  public:
    using Microseconds = std::function<std::int64_t()>;

    /// Between two looks at where the log ends.
    static constexpr std::int64_t poll_us = 250'000;
    /// Four looks, each of which may have to be repeated over a new connection.
    static constexpr std::int64_t current_us = 2'000'000;
    /// After a silence the log has to answer for so long before what it says is taken for all that there is.
    static constexpr std::int64_t settles_us = 2 * poll_us;
    /// A change that is stored so much later than it was made has lapsed, wherever it was meanwhile. By the engine's clock: one that
    /// is ahead of the server's by more takes no change.
    static constexpr std::int64_t stored_within_us = 1'000'000;
    /// As long takes the first exchange of words with others, where there are some.
    static constexpr std::int64_t compares_us = 2'500'000;
    /// A change whose end is not known is written as often, under one id, before it is `unknown`.
    static constexpr int writes_max = 3;

    struct Options {
        std::string name;    ///< for messages
        std::string writer;  ///< unlike that of any other process: part of each message's id
        Microseconds steady; ///< never set back
        Microseconds utc;    ///< until there is a clock of the sea: compare_clocks()
    };

    /// Reads the log, or begins it; of several who begin it at once one does, the others have its sea. Errors name what
    /// is wrong with the log.
    static Result<std::unique_ptr<SharedJournal>> open(std::unique_ptr<SharedLog> log,
                                                       const Beginning& beginning, Options options);
    /// What carries words between its servers; before compare_clocks().
    void talk_over(std::unique_ptr<PeerLine> line) { line_ = std::move(line); }
    /// Stops following.
    ~SharedJournal() override;

    /// Polls from now on, on a thread of its own.
    void follow();
    /// Asks where the log ends and holds what is new. True: there was something. For tests; else follow().
    bool poll();

    const std::string& name() const override { return options_.name; }
    std::int64_t epoch_utc_us() const override { return epoch_utc_us_; }
    using Journal::since;
    Result<std::vector<SeaChange>> since(std::uint32_t epoch, std::size_t most) const override;
    Result<void> append(const SeaChange& change) override;
    JournalStanding standing() const override;
    std::int64_t spread_us() const override { return current_us + stored_within_us; }
    void compare_clocks(std::function<std::int64_t()> elapsed_us) override;
    void connect_no_more() override { log_->connect_no_more(); }
    void call_on_change(std::function<void()> call) override;

  private:
    SharedJournal(std::unique_ptr<SharedLog> log, Options options);

    Result<void> begin(const Beginning& beginning);
    /// Holds what the log has; its tail as of then.
    Result<SharedLog::Tail> catch_up();
    bool is_held(const SharedLog::Stored& stored) const;
    Result<void> hold(const SharedLog::Stored& stored, std::uint64_t number);
    Result<void> write(const LoggedChange& logged);
    /// Whether that message was written under this id.
    Result<bool> stands_under(const std::string& id, std::uint64_t number);
    Error wrong(const std::string& why) const;
    Error refused(const Error& why) const;
    /// By the clock of the sea, once that runs.
    std::int64_t utc_us() const;
    Result<void> check_with_utc(std::int64_t behind_us);
    /// Remembers what came of asking the log.
    void heard(std::int64_t asked_us, const Result<SharedLog::Tail>& tail);
    void run();

    const Options options_;
    std::mutex log_mutex_; ///< one asks it at a time
    const std::unique_ptr<SharedLog> log_;
    std::string identity_;            ///< of the log, once it was read
    std::uint64_t sum_ = 0;           ///< of what is held, verdicts included
    std::int64_t last_at_utc_us_ = 0; ///< of the last one that is held
    std::int64_t last_by_utc_us_ = 0; ///< and by when it had to be stored
    std::uint64_t writes_ = 0;
    bool lapses_ = false;           ///< the last one that was made did so at once
    std::int64_t epoch_utc_us_ = 0; ///< never changes once it is open

    mutable std::mutex mutex_; ///< of what follows
    std::vector<SeaChange> changes_;
    std::int64_t known_us_ = 0;           ///< when it was asked, and ended where it is held to
    std::optional<std::int64_t> sure_us_; ///< of the last answer, if it was from who has a majority
    std::int64_t sure_since_us_ = 0;      ///< and so were all since then
    std::string trouble_;
    std::mutex call_mutex_; ///< while it is called, too: who takes it back is called no more
    std::function<void()> call_;

    PeerClocks clocks_;
    std::function<std::int64_t()> elapsed_us_; ///< none: clocks are not compared
    std::int64_t comparing_since_us_ = 0;
    std::unique_ptr<PeerLine> line_; ///< ends before what it calls

    std::mutex stop_mutex_;
    std::condition_variable stop_;
    bool stopping_ = false;
    std::thread thread_;
};

} // namespace seaway::server
