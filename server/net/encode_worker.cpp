// SPDX-License-Identifier: Apache-2.0
#include "server/net/encode_worker.h"

namespace seaway::server {

EncodeWorker::EncodeWorker() : thread_([this] { run(); }) {}

EncodeWorker::~EncodeWorker() {
    stop();
}

bool EncodeWorker::submit_streamed(Job job) {
    return submit(streamed_, streamed_waiting_max, std::move(job));
}

bool EncodeWorker::submit_fetched(Job job) {
    return submit(fetched_, fetches_waiting_max, std::move(job));
}

bool EncodeWorker::submit(std::deque<Job>& line, std::size_t waiting_max, Job job) {
    {
        const std::lock_guard lock(mutex_);
        if (stopping_ || line.size() >= waiting_max)
            return false;
        line.push_back(std::move(job));
    }
    wake_.notify_one();
    return true;
}

void EncodeWorker::stop() {
    std::deque<Job> streamed;
    std::deque<Job> fetched; // what jobs hold is released outside the lock
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        streamed.swap(streamed_);
        fetched.swap(fetched_);
    }
    wake_.notify_one();
    if (thread_.joinable())
        thread_.join();
}

EncoderCounters EncodeWorker::counters() const {
    const std::lock_guard lock(mutex_);
    return counters_;
}

void EncodeWorker::run() {
    Encoder encoder;
    std::unique_lock lock(mutex_);
    while (true) {
        wake_.wait(lock, [&] { return stopping_ || !streamed_.empty() || !fetched_.empty(); });
        if (stopping_)
            return;
        std::deque<Job>& line = streamed_.empty() ? fetched_ : streamed_;
        {
            Job job = std::move(line.front());
            line.pop_front();
            lock.unlock();
            job(encoder);
        }
        lock.lock();
        counters_ = encoder.counters();
    }
}

} // namespace seaway::server
