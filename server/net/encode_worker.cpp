// SPDX-License-Identifier: Apache-2.0
#include "server/net/encode_worker.h"

#include <new>

namespace seaway::server {

EncodeWorker::EncodeWorker(MemoryPtr memory)
    : memory_(std::move(memory)), encoder_(memory_->room(MemoryUse::encoded)),
      thread_([this] { run(); }) {}

EncodeWorker::~EncodeWorker() {
    stop();
}

bool EncodeWorker::submit_streamed(Job job, std::size_t bytes) {
    return submit(streamed_, streamed_waiting_max, std::move(job), bytes);
}

bool EncodeWorker::submit_fetched(Job job) {
    return submit(fetched_, fetches_waiting_max, std::move(job));
}

bool EncodeWorker::submit_start(Job job) {
    return submit(starts_, starts_waiting_max, std::move(job));
}

bool EncodeWorker::submit(Line& line, std::size_t waiting_max, Job job, std::size_t bytes) {
    {
        const std::lock_guard lock(mutex_);
        if (stopping_ || line.size() >= waiting_max)
            return false;
        Room::Place place;
        if (bytes > 0 && !(place = memory_->room(MemoryUse::encoding)->take(bytes)))
            return false;
        line.push_back({std::move(job), std::move(place)});
    }
    wake_.notify_one();
    return true;
}

void EncodeWorker::stop() {
    Line dropped[3]; // what jobs hold is released outside the lock
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        dropped[0].swap(streamed_);
        dropped[1].swap(fetched_);
        dropped[2].swap(starts_);
    }
    wake_.notify_one();
    if (thread_.joinable())
        thread_.join();
}

EncoderCounters EncodeWorker::counters() const {
    return encoder_.counters();
}

EncodeWorker::Line* EncodeWorker::next_line() {
    if (!streamed_.empty())
        return &streamed_;
    starts_turn_ = !starts_turn_;
    if (fetched_.empty() || (starts_turn_ && !starts_.empty()))
        return starts_.empty() ? nullptr : &starts_;
    return &fetched_;
}

void EncodeWorker::run() {
    std::unique_lock lock(mutex_);
    while (true) {
        Line* line = nullptr;
        wake_.wait(lock, [&] { return stopping_ || (line = next_line()) != nullptr; });
        if (stopping_)
            return;
        Waiting next = std::move(line->front());
        line->pop_front();
        lock.unlock();
        bool done = true; // also where there is no memory for it
        try {
            done = next.job(encoder_);
        } catch (const std::bad_alloc&) {
        }
        if (done)
            next = {}; // what it holds is released outside the lock
        lock.lock();
        try {
            if (!done && !stopping_)
                line->push_front(std::move(next));
        } catch (const std::bad_alloc&) { // whose job it was is told by its end
        }
    }
}

} // namespace seaway::server
