// SPDX-License-Identifier: Apache-2.0
// SeaDirector: who changes the sea of a running server. One change after the other: it is checked, its seas are made, it
// is written to the journal, and only then it is part of the course and told to everybody, long enough before it begins.
// What others have appended to the journal it plays as it comes, in order. Also tells of the seas of the timetable when their
// time comes near.
//
// Has a thread of its own, for seas take their time; nobody else waits for them. Thread-safe.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/journal/journal.h"
#include "server/world.h"

namespace seaway::server {

/// Changes that wait for those before them.
inline constexpr std::size_t changes_waiting_max = 16;
/// Changes that are promised and have not begun, of those that are told of already: the seas of more would throw out those
/// that run (SeaCourse, seas_kept).
inline constexpr std::size_t changes_promised_max = 3;
/// From so many of changes_max on each change is warned of.
inline constexpr std::size_t changes_warned_of = changes_max / 10 * 9;

class SeaDirector {
  public:
    /// All outlive it; `journal` may be null, `changes` is the count of those that it holds. Takes over World::change().
    SeaDirector(std::shared_ptr<SeaCourse> course, Journal* journal, std::uint32_t changes,
                World& world, SeaClock& clock);
    /// Those that wait are refused.
    ~SeaDirector();
    SeaDirector(const SeaDirector&) = delete;
    SeaDirector& operator=(const SeaDirector&) = delete;

    /// `done` is called once, on the director's thread or at once. Errors: bad_value with what of the wish cannot be;
    /// busy, also where another server's change was first, the journal cannot be reached, or the clock is behind what it was
    /// when the last one was made; CourseError::full where the log holds as many as it may; one without a kind where the journal
    /// could not be written, or it is not known whether it was.
    void change(SeaWish wish, Host::Changed done);

  private:
    struct Asked {
        SeaWish wish;
        Host::Changed done;
    };
    void follow_journal();
    /// Nobody calls it any more.
    void let_go();
    void run();
    /// Plays what others have appended.
    void follow();
    /// And looks for doubt. Where there is no memory now, the next look does; until then it is behind.
    void follow_if_there_is_memory();
    /// The journal has more than was played, since now.
    void falls_behind();
    Result<void> play(const SeaChange& change);
    Following following() const;
    /// The journal is to know of each sea that begins, once; where it cannot be written, a minute later.
    void note_begun();
    /// Says that the sea's clock has leapt since the last look.
    void look_at_clock();
    /// Says that the log is nearly full.
    void look_at_room() const;
    /// Sends the sessions to other servers when this one begins to doubt its sea, or sessions were told of a change when it had begun.
    void look_for_doubt();
    /// Where there is no memory now, the next look does.
    void announce();
    static void tell(const Asked& asked, const Result<SeaPromise>& promise);
    /// An error, busy: this server is not sure of its sea, so that a change would be of another one, or of another time.
    Result<void> check_certain() const;
    /// An error, busy: more are promised than may be, and this one would begin soon.
    Result<void> check_promised(const SeaWish& wish);
    /// An error, busy: too many before it have taken over from changes that had not ended.
    Result<void> check_takeovers(sea::TimeUs start_us) const;
    /// Ask again at that time of the sea.
    Error busy_until(sea::TimeUs sea_us, const std::string& why) const;
    Result<SeaPromise> make(const SeaWish& wish);
    /// Written durably, where there is a journal, and then played: `effect`. Where there is no memory for either, follow()
    /// plays what was written once there is: the error says so. Its number in the journal; 0: there is none.
    Result<std::uint32_t> log(SeaChange change, const std::function<void()>& effect);
    Result<void> append(const SeaChange& change);
    /// Sessions were told of a change of its own when it had begun: they are sent away, to begin with what is true.
    void was_late();
    /// The time that others need to hear of a change, in sea time.
    sea::TimeUs spread() const;
    /// How fast the sea runs, soon.
    Result<SeaPromise> make_pace(int permille);
    /// Written, and followed where that was in time for all who are here to hear of it: otherwise false.
    Result<bool> log_pace(const sea::Pace& pace);
    void follow(const sea::Pace& pace);
    struct Planned {
        sea::Scene scene;
        RunningSeaPtr to;
        SeaPromise promise;
        bool soonest;
    };
    /// A change that can be added, and begins late enough for that.
    Result<Planned> plan(const SeaWish& wish) const;
    /// Its scene if it begins then: values are set in what runs, or is glided to, at that time.
    Result<sea::Scene> wished(const SeaWish& wish, sea::TimeUs from_us) const;
    /// When every keyframe that is out by now is of the sea before.
    sea::TimeUs first_start(const RunningSea& to) const;
    struct Start {
        sea::TimeUs start_us;
        bool soonest; ///< as soon as can be: no time is wished, or an earlier one
    };
    /// When it is wished, exactly, so that changes for one time begin with one another; or as soon as can be, in the order in
    /// which changes were asked for, and where keyframes of both seas lie.
    Start start_of(const SeaWish& wish, const RunningSea& to, sea::TimeUs making_us) const;
    /// It takes over from those that were to begin later, or with it.
    void is_promised(sea::TimeUs start_us);

    const std::shared_ptr<SeaCourse> course_;
    Journal* const journal_;
    std::atomic<std::uint32_t> changes_; ///< that were played
    std::atomic<std::int64_t> behind_since_us_ =
        0; ///< by the steady clock; 0: all that the journal holds is played
    std::atomic<std::int64_t> writing_since_us_ = 0; ///< likewise, a change of its own; 0: none
    /// A pace of its own that others follow and it does not, until the next one holds.
    std::atomic<std::int64_t> passed_over_since_us_ = 0;                ///< by the steady clock
    std::atomic<sea::TimeUs> passed_over_until_us_ = -sea::time_us_max; ///< since the epoch
    /// Times that were wished for a change which begins later, from the first of them until that: one for such a time begins behind it,
    /// too. If it is made sooner it would begin before, and what was wished before it would be lost.
    struct Passed {
        sea::TimeUs from_us = sea::time_us_max;
        sea::TimeUs until_us =
            -sea::time_us_max; ///< start of the last that was to begin as soon as can be

        bool hold(sea::TimeUs time_us) const { return from_us <= time_us && time_us < until_us; }
        void add(sea::TimeUs wished_us, sea::TimeUs start_us, sea::TimeUs now_us) {
            if (until_us <= now_us)
                from_us = sea::time_us_max;
            if (wished_us > now_us)
                from_us = std::min(from_us, wished_us);
            until_us = start_us;
        }
    };
    std::string doubt_; ///< of the last look; this and what follows of the director's thread
    bool handed_over_for_doubt_ = false; ///< that lasts
    bool missed_ = false;                ///< a change had begun when it came
    bool follows_ = true;                ///< there was memory for it at the last look
    std::int64_t handed_over_us_ = 0;
    sea::TimeUs leapt_us_ = 0;          ///< all that was told of
    std::uint32_t begun_epoch_ = 0;     ///< that the journal knows of
    std::int64_t note_again_us_ = 0;    ///< by the steady clock
    std::vector<sea::TimeUs> promised_; ///< starts that have not come; of the director's thread
    Passed passed_;
    World& world_;
    SeaClock& clock_;

    mutable std::mutex mutex_; ///< of what follows
    std::condition_variable wake_;
    std::deque<Asked> asked_;
    bool journal_grew_ = false;
    std::string stuck_; ///< why what the journal holds next cannot be played
    bool stopping_ = false;
    std::thread thread_;
};

} // namespace seaway::server
