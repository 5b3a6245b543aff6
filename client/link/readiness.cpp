// SPDX-License-Identifier: Apache-2.0
#include "client/link/readiness.h"

#include <cerrno>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "client/link/failure.h"

namespace seaway::client {
namespace {

constexpr long tick_ns = 50'000'000;

void due_after(int timer, long ns) {
    const itimerspec when{{0, tick_ns}, {0, ns}};
    ::timerfd_settime(timer, 0, &when, nullptr);
}

Error none_left() {
    return failed(Failure::none,
                  fmt::format("no descriptor to wait for: {}", std::strerror(errno)));
}

} // namespace

Result<std::unique_ptr<Readiness>> Readiness::create() {
    const int both = ::epoll_create1(EPOLL_CLOEXEC);
    if (both < 0)
        return none_left();
    const int due = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
    if (due < 0) {
        const Error why = none_left();
        ::close(both);
        return why;
    }
    std::unique_ptr<Readiness> made(new Readiness(both, due));
    SEAWAY_TRY(made->add(due));
    due_after(due, tick_ns);
    return made;
}

Readiness::~Readiness() {
    ::close(due_);
    ::close(both_);
}

Result<void> Readiness::add(int descriptor) {
    epoll_event wanted{};
    wanted.events = EPOLLIN;
    wanted.data.fd = descriptor;
    if (::epoll_ctl(both_, EPOLL_CTL_ADD, descriptor, &wanted) == 0 || errno == EEXIST)
        return {};
    return none_left();
}

void Readiness::wake() {
    due_after(due_, 1);
}

void Readiness::clear() {
    std::uint64_t times = 0;
    (void)!::read(due_, &times, sizeof(times));
}

} // namespace seaway::client
