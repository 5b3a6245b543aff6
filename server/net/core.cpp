// SPDX-License-Identifier: Apache-2.0
#include "server/net/core.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/messages.h"
#include "protocol/limits.h"
#include "server/net/session.h"

namespace seaway::server {

Core::Core(NetOptions net_options, Host& simulation, std::function<void(Work)> run_on_io_thread,
           Turns::Now now)
    : options(std::move(net_options)), host(simulation), addresses(options), memory(host.memory()),
      encoding(memory), turns(
                            [this](Work turn) {
                                post([weak = weak_from_this(), turn = std::move(turn)] {
                                    if (const std::shared_ptr<Core> core = weak.lock())
                                        turn();
                                });
                            },
                            std::move(now)),
      map_places(maps_at_once_max, [this](Work work) { post(std::move(work)); }),
      run_on_io_thread_(std::move(run_on_io_thread)) {
    health_door.health_only = true;
}

void Core::post(Work work) {
    const std::lock_guard lock(post_mutex_);
    if (run_on_io_thread_)
        run_on_io_thread_(std::move(work));
}

void Core::detach() {
    const std::lock_guard lock(post_mutex_);
    run_on_io_thread_ = nullptr;
}

Session* Core::find(SessionId session) const {
    const auto found = sessions.find(session);
    return found == sessions.end() ? nullptr : found->second;
}

Gauges Core::gauges() const {
    Gauges gauges{.sessions = sessions.size(),
                  .sessions_max = static_cast<std::size_t>(options.sessions_max),
                  .subscriptions = host.subscriptions().size(),
                  .connections = static_cast<std::size_t>(door.connections),
                  .outbox_bytes = 0,
                  .outboxes = {}};
    for (const auto& [id, session] : sessions) {
        gauges.outbox_bytes += session->outbox().bytes_waiting();
        gauges.outboxes += session->outbox().counters();
    }
    return gauges;
}

std::chrono::milliseconds Core::pause_of_all(double least_s) const {
    constexpr double most_s = protocol::limits::retry_after_ms_max / 1000.0;
    const double spread_s = static_cast<double>(sessions.size()) / comers_per_s;
    const double wait_s =
        options.retry_after_s > 0 ? options.retry_after_s : std::clamp(spread_s, least_s, most_s);
    return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(wait_s));
}

void Core::begin_to_hand_over(const std::string& why) {
    retry_after = pause_of_all(hand_over_s_min);
    log_act(fmt::format("event=handing_over sessions={} retry_after_ms={} why={}", sessions.size(),
                        retry_after.count(), in_quotes(why)));
}

void Core::begin_to_stop() {
    retry_after = pause_of_all(retry_after_s_min);
    stopping = true;
    log_act(fmt::format("event=stopping sessions={} drain_s={} retry_after_ms={}", sessions.size(),
                        options.drain_s, retry_after.count()));
}

void Core::log(const std::string& line) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    const std::int64_t second = std::chrono::duration_cast<std::chrono::seconds>(now).count();
    if (second != log_second_) {
        log_second_ = second;
        log_lines_ = 0;
    }
    if (++log_lines_ > log_lines_per_second_max) {
        ++log_left_out_;
        return;
    }
    if (log_left_out_ > 0)
        spdlog::warn("event=log_lines_left_out count={}", std::exchange(log_left_out_, 0));
    spdlog::info("{}", line);
}

void Core::log_act(const std::string& line) {
    spdlog::info("{}", line);
}

} // namespace seaway::server
