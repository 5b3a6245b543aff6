// SPDX-License-Identifier: Apache-2.0
// Account: what one asker may have worked for it: so much of the threads' time a second, and some
// of it saved up. A bucket of microseconds that fills at `rate`; a request may be made while there is
// anything in it, and takes its price out, which may leave a debt: so one large request is possible and
// the next one waits. Work beyond the price is taken out as it is done: all of it at the end would come after the bucket had been
// full for as long, and flowed over. Plain arithmetic on times that are given.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

namespace seaway::server {

/// Of each asker.
struct WorkBudget {
    /// Seconds of work a second. As many as there are threads that work for those who ask: who waits for
    /// answers before asking more is never refused.
    double rate = 1;
    /// Work that may be asked for at once, beyond the rate, s.
    double burst_s = 10;
};

inline double steady_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

class Account {
  public:
    Account(const WorkBudget& budget, double now_s)
        : budget_(budget), balance_us_(full_us()), at_s_(now_s) {}

    bool may_ask(double now_s) {
        refill(now_s);
        return balance_us_ > 0;
    }
    void take(double price_us) { balance_us_ -= price_us; }
    void take(double us, double now_s) {
        refill(now_s);
        take(us);
    }
    void give_back(double us) { balance_us_ = std::min(balance_us_ + us, full_us()); }

    /// Until may_ask() again.
    double wait_s() const { return balance_us_ > 0 ? 0 : (1 - balance_us_) * 1e-6 / budget_.rate; }
    bool full(double now_s) {
        refill(now_s);
        return balance_us_ >= full_us();
    }

  private:
    double full_us() const { return 1e6 * budget_.burst_s; }
    void refill(double now_s) {
        give_back(std::max(now_s - at_s_, 0.0) * 1e6 * budget_.rate);
        at_s_ = std::max(now_s, at_s_);
    }

    WorkBudget budget_;
    double balance_us_;
    double at_s_;
};

} // namespace seaway::server
