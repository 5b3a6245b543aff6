// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/sky_feed.h"

#include <algorithm>
#include <utility>

namespace seaway::client {

namespace {

int half_of_the_cores() {
    return std::max(static_cast<int>(std::thread::hardware_concurrency()) / 2, 1);
}

} // namespace

SkyFeed::SkyFeed() : thread_([this] { run(); }) {}

SkyFeed::~SkyFeed() {
    {
        const std::scoped_lock lock(mutex_);
        stop_ = true;
        changed_.notify_all();
    }
    thread_.join();
}

void SkyFeed::run() {
    SkyMaker maker(half_of_the_cores());
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return stop_ || mailbox_; });
        if (stop_)
            return;
        const Wanted wanted = *std::exchange(mailbox_, {});
        making_ = true;
        lock.unlock();
        Result<Sky> sky = maker.make(wanted.look, wanted.heavens, wanted.eye);
        lock.lock();
        making_ = false;
        error_ = sky ? std::string() : sky.error().message;
        if (sky) {
            made_ = std::move(*sky);
            ++counts_.made;
        }
        changed_.notify_all();
    }
}

Result<Sky> SkyFeed::at(const Look& look, const Heavens& heavens, const Eye& eye) {
    Wanted wanted{look, heavens, eye_on_steps(look, eye)};
    std::unique_lock lock(mutex_);
    if (asked_ != wanted) {
        asked_ = wanted;
        mailbox_ = std::move(wanted);
        if (!now_)
            error_.clear(); // of another wish
        changed_.notify_all();
    }
    if (!now_)
        changed_.wait(lock, [&] { return made_ || !error_.empty(); });
    else if (making_ || mailbox_)
        ++counts_.frames_meanwhile;
    if (made_) {
        const bool near = now_ && may_be_mixed(*now_, *made_);
        before_ = near ? std::optional(shown()) : std::nullopt;
        now_ = std::exchange(made_, {});
        mixed_ = near ? 0 : mixed_frames;
    }
    if (!now_) {
        asked_.reset(); // another call tries again
        return Error{error_};
    }
    mixed_ = std::min(mixed_ + 1, mixed_frames);
    if (mixed_ == mixed_frames)
        before_.reset();
    lock.unlock();
    return shown().seen_from(look, eye);
}

/// As far as it is mixed.
Sky SkyFeed::shown() {
    return before_ ? mixed(*before_, *now_, static_cast<double>(mixed_) / mixed_frames) : *now_;
}

std::string SkyFeed::error() const {
    const std::scoped_lock lock(mutex_);
    return error_;
}

bool SkyFeed::settled() const {
    const std::scoped_lock lock(mutex_);
    return !making_ && !mailbox_ && !made_ && mixed_ == mixed_frames;
}

void SkyFeed::wait() const {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !making_ && !mailbox_; });
}

SkyFeed::Counts SkyFeed::counts() const {
    const std::scoped_lock lock(mutex_);
    return counts_;
}

} // namespace seaway::client
