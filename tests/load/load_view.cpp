// SPDX-License-Identifier: Apache-2.0
// What a client that draws spends besides drawing: it is connected and subscribed as the window is, follows the
// server's clock, unpacks what comes and copies it to the device at every frame, and draws nothing.
//
//     load_view URL SECONDS [FRAMES_PER_SECOND]    a row every minute, and one at the end
//
// seconds since the start; CPU of this process, % of a core, since the row before; resident memory, MB;
// keyframes a second; maps copied to the device a second; frames of which the sea was held, %.
// Exit code 1: no sea was held in the last row's time.
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

#include "base/elapsed.h"
#include "client/view/sea/device_sea.h"
#include "client/view/sea/sea_source.h"
#include "client/window/feed.h"
#include "gpu/device.h"
#include "tests/support/process_status.h"

using namespace seaway;
using namespace seaway::client;
using Clock = std::chrono::steady_clock;

namespace {

class Watcher {
  public:
    Watcher(gpu::Device& device, const char* url) : feed_(options(url)), device_(&device) {}

    Result<void> create() {
        SEAWAY_TRY_LET(sea_, DeviceSea::create(*device_, {}));
        SEAWAY_TRY_LET(values_,
                       gpu::Buffer::create(*device_, "view values", sizeof(shaders::ViewValues),
                                           gpu::BufferKind::upload));
        begin_row();
        return {};
    }

    Result<void> frame() {
        ++frames_;
        const std::shared_ptr<Client> client = feed_.client();
        if (!client)
            return {};
        const Result<SeaFrame> held = held_sea_frame(*client, client->now_us());
        if (!held)
            return {};
        ++held_;
        return sea_.take(*held, values_);
    }

    /// True: the sea was held in some of its frames.
    bool row() {
        const double seconds = std::chrono::duration<double>(Clock::now() - row_start_).count();
        const FeedStatus status = feed_.status();
        fmt::print("{:.0f},{:.2f},{:.1f},{:.2f},{:.2f},{:.1f}\n",
                   std::chrono::duration<double>(Clock::now() - start_).count(),
                   100 * (process_cpu_seconds() - row_cpu_s_) / seconds,
                   1e-6 * seaway::tests::memory_bytes(::getpid()),
                   static_cast<double>(status.keyframes - row_keyframes_) / seconds,
                   static_cast<double>(sea_.copies() - row_copies_) / seconds,
                   100.0 * held_ / std::max(frames_, 1));
        std::fflush(stdout);
        const bool any = held_ > 0;
        begin_row();
        return any;
    }

  private:
    static ConnectOptions options(const char* url) {
        ConnectOptions options;
        options.url = url;
        return options;
    }
    void begin_row() {
        row_start_ = Clock::now();
        row_cpu_s_ = process_cpu_seconds();
        row_keyframes_ = feed_.status().keyframes;
        row_copies_ = sea_.copies();
        frames_ = held_ = 0;
    }

    Feed feed_;
    gpu::Device* device_;
    DeviceSea sea_;
    gpu::Buffer values_;
    const Clock::time_point start_ = Clock::now();
    Clock::time_point row_start_;
    double row_cpu_s_ = 0;
    std::uint64_t row_keyframes_ = 0, row_copies_ = 0;
    int frames_ = 0, held_ = 0;
};

Result<bool> watch(const char* url, double seconds, double frames_a_second) {
    SEAWAY_TRY_LET(const auto device, gpu::Device::create({}));
    Watcher watcher(*device, url);
    SEAWAY_TRY(watcher.create());
    fmt::print("s,cpu_pct,resident_mb,keyframes_per_s,copies_per_s,held_pct\n");
    const auto frame = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(1 / frames_a_second));
    const Clock::time_point start = Clock::now();
    const Clock::time_point end =
        start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    Clock::time_point next = start, next_row = start + std::chrono::minutes(1);
    while (Clock::now() < end) {
        SEAWAY_TRY(watcher.frame());
        if (Clock::now() >= next_row) {
            watcher.row();
            next_row += std::chrono::minutes(1);
        }
        std::this_thread::sleep_until(next += frame);
    }
    return watcher.row();
}

bool read(const char* text, double least, double& value) {
    const auto [rest, failure] = std::from_chars(text, text + std::strlen(text), value);
    return failure == std::errc{} && *rest == '\0' && value >= least && value <= 1e6;
}

} // namespace

int main(int argc, char** argv) {
    double seconds = 0, frames_a_second = 60;
    if (argc < 3 || argc > 4 || !read(argv[2], 1, seconds) ||
        (argc == 4 && !read(argv[3], 0.1, frames_a_second))) {
        fmt::print(stderr, "usage: load_view URL SECONDS [FRAMES_PER_SECOND], from 1 and 0.1 on\n");
        return 2;
    }
    const Result<bool> held = watch(argv[1], seconds, frames_a_second);
    if (!held)
        fmt::print(stderr, "load_view: {}\n", held.error().message);
    return held && *held ? 0 : 1;
}
