// SPDX-License-Identifier: Apache-2.0
// What a library owes the program that it runs in: its signals, its small stacks, the programs that it starts, its time.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <gtest/gtest.h>

#include "base/fair_mutex.h"
#include "tests/client/engine.h"
#include "tests/support/eventually.h"
#include "tests/support/process_status.h"

namespace seaway {
namespace {

using std::chrono::steady_clock;

class InAProgram : public tests::Engine {
  protected:
    std::string url() const { return net->url(); }
};

TEST_F(InAProgram, no_thread_of_the_library_takes_its_signals) {
    std::set<std::filesystem::path> before;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
        before.insert(task.path());
    const Sea client(url());
    // A thread that has just been made has all of them blocked until it runs, and Asio's, which looks up names and calls nobody,
    // for good.
    int threads = 0;
    const auto callers = [&] {
        threads = 0;
        int see_faults = 0;
        for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
            if (before.contains(task.path()))
                continue;
            ++threads;
            const std::uint64_t blocked = tests::signals_in(task, "SigBlk");
            const auto blocks = [&](int signal) { return (blocked >> (signal - 1) & 1) != 0; };
            for (const int signal : {SIGTERM, SIGINT, SIGALRM, SIGCHLD, SIGUSR1})
                EXPECT_TRUE(blocks(signal)) << signal;
            const auto own = {SIGSEGV, SIGBUS,  SIGFPE,   SIGILL,       SIGABRT,
                              SIGPWR,  SIGXCPU, SIGRTMIN, SIGRTMIN + 1, SIGRTMAX};
            see_faults += std::none_of(own.begin(), own.end(), blocks);
        }
        return see_faults;
    };
    EXPECT_TRUE(tests::eventually([&] { return callers() >= 2; }))
        << "a fault in a callback is the program's to see, and a runtime stops who has called it";
    EXPECT_GE(threads, 2);
    sigset_t mine;
    pthread_sigmask(SIG_SETMASK, nullptr, &mine);
    EXPECT_FALSE(sigismember(&mine, SIGTERM)) << "who connects is as before";
}

/// How much of a stack `job` used, bytes.
template <class Job>
std::size_t stack_of(Job job) {
    constexpr std::size_t bytes = std::size_t{1} << 20;
    constexpr unsigned char untouched = 0x5a;
    void* const memory =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    std::memset(memory, untouched, bytes);
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, memory, bytes);
    pthread_t thread;
    const auto run = [](void* given) -> void* {
        (*static_cast<Job*>(given))();
        return nullptr;
    };
    EXPECT_EQ(pthread_create(&thread, &attributes, run, &job), 0);
    pthread_join(thread, nullptr);
    pthread_attr_destroy(&attributes);
    const auto* const first = static_cast<const unsigned char*>(memory);
    const std::size_t left = static_cast<std::size_t>(
        std::find_if(first, first + bytes, [](unsigned char b) { return b != untouched; }) - first);
    ::munmap(memory, bytes);
    return bytes - left;
}

// What seaway.h states, in which the thread's own and what the sanitizers add are not.
TEST_F(InAProgram, samples_fit_on_the_stack_of_a_fibre) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    constexpr std::size_t stated_bytes = 480 << 10;
#else
    constexpr std::size_t stated_bytes = 48 << 10;
#endif
    const std::vector<seaway_point> points = places(200);
    for (const bool tiles : {true, false}) {
        Sea client(url());
        hold_sea(client, tiles);
        std::vector<seaway_answer> answers(points.size());
        std::vector<seaway_water> water(points.size());
        const std::size_t idle = stack_of([] {});
        for (int round = 0; round < 2; ++round) {
            EXPECT_LT(stack_of([&] {
                          EXPECT_EQ(seaway_sample(client.handle(), points.data(), points.size(),
                                                  answers.data()),
                                    SEAWAY_OK);
                      }) - idle,
                      stated_bytes);
            EXPECT_LT(stack_of([&] {
                          EXPECT_EQ(seaway_sample_water(client.handle(), nullptr, points.data(),
                                                        points.size(), water.data(),
                                                        sizeof(seaway_water)),
                                    SEAWAY_OK);
                      }) - idle,
                      stated_bytes);
        }
    }
}

// A program that is started would hold the connection, and its place at the server, when this one has ended.
TEST_F(InAProgram, no_descriptor_of_the_library_is_handed_to_programs_that_are_started) {
    std::set<std::string> before;
    for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd"))
        before.insert(file.path().filename());
    for (const std::uint32_t threadless : {0u, 1u}) {
        seaway_connect_options options{};
        options.threadless = threadless;
        seaway_client* client = nullptr;
        ASSERT_EQ(seaway_connect(url().c_str(), &options, &client), SEAWAY_OK);
        const std::uint16_t port = net->port();
        int connections = 0;
        for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
            const int handle = std::stoi(file.path().filename());
            sockaddr_in peer{};
            socklen_t size = sizeof(peer);
            if (before.contains(file.path().filename()) ||
                ::getpeername(handle, reinterpret_cast<sockaddr*>(&peer), &size) != 0 ||
                ntohs(peer.sin_port) != port)
                continue; // the server's own end is here, too
            ++connections;
            EXPECT_TRUE(::fcntl(handle, F_GETFD) & FD_CLOEXEC);
        }
        EXPECT_EQ(connections, 1);
        seaway_disconnect(client);
    }
}

// Each turn is 20 ms at most. Who does not wait is not kept waiting by who does; who does gets its turn.
TEST_F(InAProgram, a_poll_that_does_not_wait_returns_at_once_beside_one_that_does) {
    seaway_connect_options options{};
    options.threadless = 1;
    seaway_client* client = nullptr;
    ASSERT_EQ(seaway_connect(url().c_str(), &options, &client), SEAWAY_OK);
    std::atomic<bool> over = false;
    std::thread other([&] {
        while (!over) {
            seaway_event event = SEAWAY_SIZED(seaway_event);
            seaway_poll(client, 0.05, &event);
        }
    });
    const auto median_wait_ms = [&] {
        std::vector<double> waits_ms;
        for (int i = 0; i < 60; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(3));
            seaway_event event = SEAWAY_SIZED(seaway_event);
            const auto began = steady_clock::now();
            EXPECT_EQ(seaway_poll(client, 0, &event), SEAWAY_OK);
            waits_ms.push_back(
                std::chrono::duration<double, std::milli>(steady_clock::now() - began).count());
        }
        std::sort(waits_ms.begin(), waits_ms.end());
        return waits_ms[30];
    };
    double wait_ms = median_wait_ms();
    for (int round = 1; round < 5 && wait_ms >= 15; ++round) // others may have the machine
        wait_ms = median_wait_ms();
    const seaway_point point{0, 0, asked_us};
    for (int i = 0; i < 10; ++i) {
        seaway_answer answer{};
        EXPECT_EQ(seaway_query(client, &point, 1, 0, 20, &answer), SEAWAY_OK);
    }
    over = true;
    other.join();
    seaway_disconnect(client);
    EXPECT_LT(wait_ms, 15) << "the median: it was more than a turn of the other";
}

TEST(FairMutex, goes_to_who_waits_and_not_to_who_has_just_had_it) {
    FairMutex mutex;
    std::atomic<int> turns = 0;
    mutex.lock();
    EXPECT_FALSE(mutex.try_lock());
    std::thread other([&] {
        const std::scoped_lock lock(mutex);
        turns = 1;
    });
    // Until it waits, which try_lock() sees.
    for (int round = 0; round < 1000 && turns == 0; ++round) {
        mutex.unlock();
        mutex.lock();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(turns, 1);
    mutex.unlock();
    other.join();
    EXPECT_TRUE(mutex.try_lock());
    mutex.unlock();
}

} // namespace
} // namespace seaway
