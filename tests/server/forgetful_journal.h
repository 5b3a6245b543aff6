// SPDX-License-Identifier: Apache-2.0
// A journal that others write, and for which there is no memory at times.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/journal/journal.h"

namespace seaway::server {

inline std::vector<SeaChange> some(const std::vector<SeaChange>& changes, std::size_t epoch,
                                   std::size_t most) {
    const std::span<const SeaChange> after =
        std::span(changes).subspan(std::min(epoch, changes.size()));
    const std::span<const SeaChange> those = after.first(std::min(most, after.size()));
    return {those.begin(), those.end()};
}

/// Shared with nobody that there is; calls may find no memory so many times.
class ForgetfulJournal final : public Journal {
  public:
    explicit ForgetfulJournal(SeaChange first) : changes_{std::move(first)} {}

    mutable std::atomic<int> reads_fail = 0; ///< since()
    std::atomic<int> appends_fail = 0;       ///< behind the write
    std::optional<JournalError> refuses;     ///< each append
    std::atomic<int> appends_take_ms = 0;
    std::atomic<std::int64_t> spread = 3'000'000; ///< 0: it is of this server alone

    const std::string& name() const override { return name_; }
    std::int64_t epoch_utc_us() const override { return 0; }
    using Journal::since;
    Result<std::vector<SeaChange>> since(std::uint32_t epoch, std::size_t most) const override {
        if (reads_fail > 0 && reads_fail-- > 0)
            throw std::bad_alloc();
        const std::scoped_lock lock(mutex_);
        return some(changes_, epoch, most);
    }
    Result<void> append(const SeaChange& change) override {
        if (refuses)
            return Error{*refuses, "it does not take it"};
        std::this_thread::sleep_for(std::chrono::milliseconds(appends_take_ms));
        by_another(change, false);
        if (appends_fail > 0 && appends_fail-- > 0)
            throw std::bad_alloc();
        return {};
    }
    std::atomic<int> begun = 0; ///< seas
    Result<void> note_begun(std::int64_t) override {
        ++begun;
        return {};
    }
    JournalStanding standing() const override {
        const std::scoped_lock lock(mutex_);
        JournalStanding standing = standing_;
        standing.last_epoch = static_cast<std::uint32_t>(changes_.size());
        return standing;
    }
    std::int64_t spread_us() const override { return spread; }
    void compare_clocks(std::function<std::int64_t()>) override {}
    void connect_no_more() override {}
    void call_on_change(std::function<void()> call) override {
        const std::scoped_lock lock(mutex_);
        call_ = std::move(call);
    }

    void stand(const JournalStanding& standing) {
        const std::scoped_lock lock(mutex_);
        standing_ = standing;
    }
    void by_another(const SeaChange& change, bool tells = true) {
        std::function<void()> call;
        {
            const std::scoped_lock lock(mutex_);
            changes_.push_back(change);
            call = call_;
        }
        if (tells && call)
            call();
    }

  private:
    const std::string name_ = "nats://nowhere/forgetful";
    mutable std::mutex mutex_;
    std::vector<SeaChange> changes_;
    JournalStanding standing_;
    std::function<void()> call_;
};

} // namespace seaway::server
