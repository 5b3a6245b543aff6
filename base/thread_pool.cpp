// SPDX-License-Identifier: Apache-2.0
#include "base/thread_pool.h"

#include <algorithm>

#include "base/check.h"
#include "base/processors.h"
#include "base/thread_name.h"

namespace seaway {

namespace {

void pause_briefly() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/// For waits that another thread's running chunk ends: a few microseconds hot, then polite.
template <class Ready>
void wait_until(Ready ready) {
    for (int spin = 0; !ready(); ++spin) {
        if (spin < 256)
            pause_briefly();
        else
            std::this_thread::yield();
    }
}

} // namespace

int awaited_phase(std::span<const Phase> phases, std::size_t index) {
    int before = phases[index].after;
    while (before >= 0 && phases[static_cast<std::size_t>(before)].chunks == 0)
        before = phases[static_cast<std::size_t>(before)].after;
    return before;
}

ThreadPool::ThreadPool(int threads, const char* name) {
    SEAWAY_CHECK(threads >= 0, "number of threads");
    if (threads == 0)
        threads = usable_processors();
    workers_.reserve(static_cast<std::size_t>(threads - 1));
    try {
        for (int worker = 1; worker < threads; ++worker)
            workers_.emplace_back([this, worker, name] {
                name_thread(name);
                serve(worker);
            });
    } catch (...) { // those that there are wait for work, and nobody would join them
        end();
        throw;
    }
}

ThreadPool::~ThreadPool() {
    end();
}

void ThreadPool::end() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& worker : workers_)
        worker.join();
}

void ThreadPool::run(std::span<const Phase> phases) {
    if (phases.size() > done_capacity_) {
        done_ = std::make_unique<std::atomic<int>[]>(phases.size());
        done_capacity_ = phases.size();
    }
    first_chunk_.assign(1, 0);
    awaited_.clear();
    for (std::size_t i = 0; i < phases.size(); ++i) {
        SEAWAY_CHECK(phases[i].after < static_cast<int>(i), "a phase may only follow earlier ones");
        SEAWAY_CHECK(phases[i].chunks >= 0, "number of chunks");
        awaited_.push_back(awaited_phase(phases, i));
        done_[i].store(0, std::memory_order_relaxed);
        first_chunk_.push_back(first_chunk_.back() + phases[i].chunks);
    }
    phases_ = phases;
    ticket_.store(0, std::memory_order_relaxed);
    if (!workers_.empty()) {
        {
            const std::lock_guard lock(mutex_);
            open_ = true;
            ++generation_;
        }
        wake_.notify_all();
    }
    work(0);
    for (std::size_t i = 0; i < phases.size(); ++i)
        wait_until([&] { return done_[i].load(std::memory_order_acquire) == phases[i].chunks; });
    if (!workers_.empty()) {
        {
            const std::lock_guard lock(mutex_);
            open_ = false;
        }
        wait_until([&] { return inside_.load(std::memory_order_acquire) == 0; });
    }
}

void ThreadPool::work(int worker) {
    std::size_t phase = 0;
    for (;;) {
        const int ticket = ticket_.fetch_add(1, std::memory_order_relaxed);
        if (ticket >= first_chunk_.back())
            return;
        while (ticket >= first_chunk_[phase + 1])
            ++phase;
        const Phase& current = phases_[phase];
        if (awaited_[phase] >= 0) {
            const auto before = static_cast<std::size_t>(awaited_[phase]);
            wait_until([&] {
                return done_[before].load(std::memory_order_acquire) == phases_[before].chunks;
            });
        }
        current.run(current.context, ticket - first_chunk_[phase], worker);
        done_[phase].fetch_add(1, std::memory_order_acq_rel);
    }
}

void ThreadPool::serve(int worker) {
    std::uint64_t seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [&] { return stop_ || (open_ && generation_ != seen); });
        if (stop_)
            return;
        seen = generation_;
        inside_.fetch_add(1, std::memory_order_relaxed); // under the lock: run() sees it or is open
        lock.unlock();
        work(worker);
        inside_.fetch_sub(1, std::memory_order_release);
        lock.lock();
    }
}

} // namespace seaway
