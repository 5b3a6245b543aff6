// SPDX-License-Identifier: Apache-2.0
// ThreadPool: a few persistent threads that work through phases of equal chunks.
//
// Chunks are handed out in order, one after the other, so threads of unequal speed share the work.
// A phase may follow an earlier phase, which must be complete before its chunks start; whoever draws
// such a chunk early waits for the chunks still running, a matter of microseconds. A phase is
// complete when its chunks are done *and* the phase it follows is complete: one of no chunks is
// complete exactly when what it follows is, so to follow it is to follow all that came before it.
// Between runs the threads sleep. Which thread runs a chunk never changes what the chunk computes.
//
//     ThreadPool pool;                       // as many threads as it may have run at once
//     const Phase phases[] = {{&columns, &work, 8}, {&rows, &work, 16, 0}};
//     pool.run(phases);                      // returns when every chunk is done
//
// run() is for one caller at a time; the caller works too, as worker 0.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

namespace seaway {

/// Chunks 0 .. chunks-1 of `run(context, chunk, worker)`; `worker` is in [0, threads()). No
/// exception may leave `run`.
struct Phase {
    void (*run)(const void* context, int chunk, int worker);
    const void* context;
    int chunks;
    int after = -1; ///< index of the earlier phase that it follows; -1: none
};

/// The phase whose chunks must all be done before the first chunk of phase `index` may start: the
/// nearest one it follows, however far back, that has chunks. -1: none. Pure.
int awaited_phase(std::span<const Phase> phases, std::size_t index);

class ThreadPool {
  public:
    /// `threads` counts the caller; 0: as many as there are `usable_processors()`. `name`: of the others, as for name_thread(). Throws std::system_error, and leaves no thread
    /// behind, where the system gives fewer.
    explicit ThreadPool(int threads = 0, const char* name = "sea-pool");
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    int threads() const { return static_cast<int>(workers_.size()) + 1; }
    void run(std::span<const Phase> phases);

  private:
    void end();
    void work(int worker);
    void serve(int worker);

    std::mutex mutex_;
    std::condition_variable wake_;
    std::uint64_t generation_ = 0; ///< of runs, guarded by mutex_
    bool open_ = false;            ///< a run may be joined, guarded by mutex_
    bool stop_ = false;            ///< guarded by mutex_

    std::span<const Phase> phases_; ///< written before open_, read by those who joined
    std::vector<int> awaited_;      ///< awaited_phase of each
    std::vector<int> first_chunk_;  ///< ticket of each phase's first chunk; one more than phases
    std::unique_ptr<std::atomic<int>[]> done_;
    std::size_t done_capacity_ = 0;
    alignas(64) std::atomic<int> ticket_{0};
    alignas(64) std::atomic<int> inside_{0};
    std::vector<std::thread> workers_;
};

} // namespace seaway
