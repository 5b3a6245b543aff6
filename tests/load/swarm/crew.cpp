// SPDX-License-Identifier: Apache-2.0
#include "tests/load/swarm/crew.h"

#include <csignal>
#include <cstdlib>
#include <memory>

#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "protocol/limits.h"
#include "tests/load/swarm/mutator.h"
#include "tests/load/swarm/peer.h"

namespace seaway::tests::swarm {
namespace {

constexpr std::uint32_t flood_under_way = protocol::limits::queries_in_flight_max;

/// What an asker waits for.
struct Asker {
    Peer* peer = nullptr;
    double asked_s = 0;
    std::uint32_t asked = 0;
    bool waits = false;
};

/// What one child does.
class Worker {
  public:
    Worker(const Errand& errand, Stage& stage, Tally& tally)
        : errand_(errand), stage_(stage), tally_(tally), poll_(::epoll_create1(0)) {}

    int work();

  private:
    void connect();
    void subscribe();
    void take(std::uint64_t which);
    void ping();
    void ask(Asker& asker);
    void flood();

    const Errand errand_;
    Stage& stage_;
    Tally& tally_;
    const int poll_;
    std::vector<std::unique_ptr<Peer>> peers_;
    std::vector<std::uint8_t> scratch_;
    std::vector<Asker> askers_;
    std::uint32_t flooded_ = 0;
    double pinging_since_s_ = 0;
    std::uint64_t pings_ = 0;
};

void Worker::connect() {
    const int subscribers = errand_.readers + errand_.stalled;
    const int others = errand_.askers + (errand_.floods ? 1 : 0);
    for (int i = 0; i < subscribers + others; ++i) {
        const bool stalled = i >= errand_.readers && i < subscribers;
        peers_.push_back(std::make_unique<Peer>(errand_.port, stalled ? 4096 : 0));
        epoll_event event{.events = EPOLLIN, .data = {.u64 = static_cast<std::uint64_t>(i)}};
        if (!stalled)
            ::epoll_ctl(poll_, EPOLL_CTL_ADD, peers_.back()->handle(), &event);
        if (i >= subscribers && i < subscribers + errand_.askers) // not all at once
            askers_.push_back({.peer = peers_.back().get(),
                               .asked_s = clock_s() + (i % 16) / (16 * errand_.asks_a_second)});
        ++stage_.greeted;
    }
}

void Worker::subscribe() {
    if (errand_.wish.fields.bits() == 0)
        return;
    const auto subscribers = static_cast<std::size_t>(errand_.readers + errand_.stalled);
    for (std::size_t i = 0; i < subscribers; ++i)
        peers_[i]->send(protocol::subscribe(1, errand_.wish, errand_.credit));
}

void Worker::take(std::uint64_t which) {
    Peer& peer = *peers_[which];
    if (peer.take(scratch_, tally_, stage_))
        return;
    ++tally_.ended;
    ::epoll_ctl(poll_, EPOLL_CTL_DEL, peer.handle(), nullptr);
}

/// The readers in turn, so that each has said as many as it should.
void Worker::ping() {
    const double now_s = clock_s();
    if (pinging_since_s_ == 0)
        pinging_since_s_ = now_s;
    const double due = (now_s - pinging_since_s_) * errand_.pings_a_second * errand_.readers;
    for (; static_cast<double>(pings_) < due; ++pings_)
        peers_[pings_ % static_cast<std::uint64_t>(errand_.readers)]->send(
            protocol::ping(static_cast<std::uint32_t>(pings_), 0));
}

/// One point when it is time and the one before is answered.
void Worker::ask(Asker& asker) {
    const double now_s = clock_s();
    if (asker.waits && asker.peer->answers() == asker.asked) {
        asker.waits = false;
        if (stage_.measure) {
            tally_.answer.add(now_s - asker.asked_s);
            tally_.answer_there.add(asker.peer->there_s() - asker.asked_s);
        }
    }
    if (asker.waits || now_s < asker.asked_s + 1 / errand_.asks_a_second)
        return;
    const double sea_s = now_s + stage_.sea_minus_clock_s;
    const sea::QueryPoint point{12.5, -7.25, static_cast<sea::TimeUs>(1e6 * sea_s)};
    asker.peer->send(protocol::query(++asker.asked, {&point, 1}, false));
    asker.asked_s = now_s;
    asker.waits = true;
}

void Worker::flood() {
    Peer& peer = *peers_.back();
    while (flooded_ < peer.answers() + flood_under_way) {
        std::vector<sea::QueryPoint> points(4096);
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i] = {1.5 * static_cast<double>(i), 3e5,
                         static_cast<sea::TimeUs>(3'600'000'000 + 1'000'000 * (i % 8))};
        peer.send(protocol::query(++flooded_, points, false));
    }
}

int Worker::work() {
    if (errand_.mutates != 0) {
        Mutator mutator(errand_.port, errand_.mutates);
        while (!stage_.end) {
            stage_.mutated += mutator.attack(scratch_);
            ++tally_.attacks;
        }
        return 0;
    }
    connect();
    bool subscribed = false;
    std::vector<epoll_event> events(256);
    while (!stage_.end) {
        if (stage_.subscribe && !std::exchange(subscribed, true))
            subscribe();
        const int patience_ms = errand_.askers > 0 ? 1 : 20;
        const int count =
            ::epoll_wait(poll_, events.data(), static_cast<int>(events.size()), patience_ms);
        for (int i = 0; i < count; ++i)
            take(events[static_cast<std::size_t>(i)].data.u64);
        if (subscribed && errand_.pings_a_second > 0 && errand_.readers > 0)
            ping();
        for (Asker& asker : askers_)
            if (subscribed)
                ask(asker);
        if (subscribed && errand_.floods)
            flood();
    }
    return 0;
}

} // namespace

Crew::~Crew() {
    for (const pid_t child : children_) {
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
    }
}

void Crew::send(const Errand& errand) {
    Tally& tally = shared<Tally>();
    tallies_.push_back(&tally);
    const pid_t child = ::fork();
    if (child == 0) {
        if (errand.nice > 0 && ::setpriority(PRIO_PROCESS, 0, errand.nice) != 0)
            std::_Exit(1);
        std::_Exit(Worker(errand, stage_, tally).work());
    }
    children_.push_back(child);
}

bool Crew::come_home() {
    bool well = true;
    for (const pid_t child : children_) {
        int status = 0;
        ::waitpid(child, &status, 0);
        well = well && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    }
    children_.clear();
    return well;
}

} // namespace seaway::tests::swarm
