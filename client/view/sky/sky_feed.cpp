// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/sky_feed.h"

#include <algorithm>
#include <new>
#include <utility>

#include "base/processors.h"

namespace seaway::client {

namespace {

int half_of_the_cores() {
    return std::max(usable_processors() / 2, 1);
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
        const bool first = counts_.made == 0, read_again = std::exchange(read_again_, false);
        lock.unlock();
        if (read_again)
            maker.forget_environment();
        Result<Sky> sky = Error{"there is no memory for another sky"};
        std::string error;
        std::exception_ptr none;
        try {
            sky = maker.make(wanted.look, wanted.heavens, wanted.eye);
            error = sky ? std::string() : sky.error().message;
            if (!sky && first)
                sky = maker.make(Look{}, heavens_at_hour(Look{}.hour), wanted.eye);
        } catch (const std::bad_alloc&) {
            none = std::current_exception();
            error = sky.error().message;
        }
        lock.lock();
        making_ = false;
        error_ = error;
        none_ = first ? none : nullptr; // of others the last one stays
        if (sky) {
            made_ = std::move(*sky);
            ++counts_.made;
        }
        changed_.notify_all();
    }
}

Sky SkyFeed::at(const Look& look, const Heavens& heavens, const Eye& eye) {
    Wanted wanted{look, heavens, eye_on_steps(look, eye)};
    std::unique_lock lock(mutex_);
    if (asked_ != wanted) {
        asked_ = wanted;
        mailbox_ = std::move(wanted);
        changed_.notify_all();
    }
    if (!now_)
        changed_.wait(lock, [&] { return made_ || none_; });
    else if (making_ || mailbox_)
        ++counts_.frames_meanwhile;
    if (!now_ && !made_) {
        asked_.reset(); // who asks again may find some
        std::rethrow_exception(std::exchange(none_, nullptr));
    }
    if (made_) {
        const bool near = now_ && may_be_mixed(*now_, *made_);
        before_ = near ? std::optional(shown()) : std::nullopt;
        now_ = std::exchange(made_, {});
        mixed_ = near ? 0 : mixed_frames;
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

void SkyFeed::read_again() {
    const std::scoped_lock lock(mutex_);
    read_again_ = true;
    asked_.reset();
}

bool SkyFeed::settled() const {
    const std::scoped_lock lock(mutex_);
    return asked_ && !making_ && !mailbox_ && !made_ && mixed_ == mixed_frames;
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
