// SPDX-License-Identifier: Apache-2.0
// SkyFeed: skies for frames that do not wait. Tables are made on a thread of its own, with half of the cores; meanwhile
// frames go on with the last ones.
//
//     SkyFeed feed;
//     const Sky sky = feed.at(look, heavens, eye);   // at once, but for the first
//
// What is asked for while tables are being made waits in a mailbox that holds the latest alone. New tables take over
// within a few frames, mixed; where the sun has turned further than a column of them, at once.
//
// at() is for one thread at a time; the rest is thread-safe. The destructor waits for the tables that are being made.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "client/view/sky/sky.h"

namespace seaway::client {

class SkyFeed {
  public:
    static constexpr int mixed_frames = 8; ///< from old tables to new ones

    SkyFeed();
    ~SkyFeed();
    SkyFeed(const SkyFeed&) = delete;
    SkyFeed& operator=(const SkyFeed&) = delete;

    /// The last sky that was made, as this eye sees it. One that cannot be made leaves the last, the first one the
    /// computed sky of the default look; why, is error(). Throws std::bad_alloc where there is no memory for a first one.
    Sky at(const Look& look, const Heavens& heavens, const Eye& eye);
    /// Of what was asked for last; empty: none.
    std::string error() const;
    /// A picture that was read, or could not be, may have changed: the next at() has it read once more.
    void read_again();
    /// The next frame shows the same tables: none are being made, none are mixed.
    bool settled() const;
    /// Until all that was asked for is made.
    void wait() const;

    struct Counts {
        int made = 0;             ///< skies
        int frames_meanwhile = 0; ///< that were given the last sky while another was being made
    };
    Counts counts() const;

  private:
    /// All that tables are made of.
    struct Wanted {
        Look look;
        Heavens heavens;
        Eye eye; ///< on the steps that tables go by
        bool operator==(const Wanted&) const = default;
    };
    void run();
    Sky shown();

    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    bool stop_ = false, making_ = false, read_again_ = false;
    std::optional<Wanted> mailbox_;
    std::optional<Wanted> asked_; ///< last
    std::optional<Sky> made_;
    std::exception_ptr none_; ///< why there is no first one
    std::string error_;
    Counts counts_;

    std::optional<Sky> before_, now_; ///< what at() mixes
    int mixed_ = mixed_frames;
    std::thread thread_;
};

} // namespace seaway::client
