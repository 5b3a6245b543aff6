// SPDX-License-Identifier: Apache-2.0
// Tally: what one process of a swarm has seen. It lies in memory that parent and child share, so it holds plain
// values only; the child writes, the parent reads when the child has ended.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <new>

#include <sys/mman.h>

namespace seaway::tests::swarm {

/// Durations from -0.2 to 5 s in steps of 0.1 ms; what is beyond is counted at the ends.
class Histogram {
  public:
    void add(double seconds) {
        const double step = (seconds - first_s) / step_s;
        const double last = static_cast<double>(counts_.size() - 1);
        ++counts_[static_cast<std::size_t>(std::clamp(step, 0.0, last))];
    }
    Histogram& operator+=(const Histogram& other) {
        for (std::size_t i = 0; i < counts_.size(); ++i)
            counts_[i] += other.counts_[i];
        return *this;
    }
    std::uint64_t count() const {
        std::uint64_t sum = 0;
        for (const std::uint32_t count : counts_)
            sum += count;
        return sum;
    }
    /// The upper end of the step that holds it, ms; -1: there is nothing.
    double quantile_ms(double share) const {
        const std::uint64_t all = count();
        if (all == 0)
            return -1;
        const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(all - 1));
        std::uint64_t sum = 0;
        std::size_t i = 0;
        while ((sum += counts_[i]) <= wanted)
            ++i;
        return 1e3 * (first_s + step_s * static_cast<double>(i + 1));
    }

  private:
    static constexpr double first_s = -0.2, step_s = 1e-4;
    std::array<std::uint32_t, 52'000> counts_{};
};

struct Tally {
    Histogram age;          ///< of a whole keyframe, beyond the lead of the schedule
    Histogram age_there;    ///< the same until the system of who reads had it
    Histogram answer;       ///< from a single point asked to its answer
    Histogram answer_there; ///< the same until the system of who asked had it
    std::uint64_t keyframes = 0;
    std::uint64_t lost = 0; ///< never seen, though a newer one of their cascade was
    std::uint64_t messages = 0;
    std::uint64_t bytes = 0;
    std::uint64_t acks = 0;
    std::uint64_t refused = 0; ///< requests
    std::uint64_t ended = 0;   ///< sessions, by the server or by a fault
    std::uint64_t attacks = 0; ///< connections of who sends what is no message

    Tally& operator+=(const Tally& other) {
        age += other.age;
        age_there += other.age_there;
        answer += other.answer;
        answer_there += other.answer_there;
        keyframes += other.keyframes;
        lost += other.lost;
        messages += other.messages;
        bytes += other.bytes;
        acks += other.acks;
        refused += other.refused;
        ended += other.ended;
        attacks += other.attacks;
        return *this;
    }
};

/// What the parent says, and how far the children have come.
struct Stage {
    std::atomic<int> greeted = 0;           ///< sessions
    std::atomic<std::uint64_t> mutated = 0; ///< messages that were no client's
    std::atomic<bool> subscribe = false, measure = false, end = false;
    std::atomic<double> sea_minus_clock_s = 0; ///< sea time less the steady clock
};

/// Memory that children share, zero at first; for as long as the process lives.
template <class T>
T& shared() {
    void* memory =
        ::mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
        throw std::bad_alloc();
    return *new (memory) T;
}

} // namespace seaway::tests::swarm
