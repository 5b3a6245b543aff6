// SPDX-License-Identifier: Apache-2.0
#include "server/net/encode_worker.h"

#include <algorithm>
#include <chrono>
#include <new>

#include "base/elapsed.h"
#include "base/thread_name.h"

namespace seaway::server {

namespace {

/// What was made for a fetch is remembered for one to two of these: others may ask for the same.
constexpr std::chrono::seconds trims_every{2};
/// Slices of no more than this are counted, longer ones measured.
constexpr double counted_slice_s = 1e-3;

} // namespace

EncodeWorker::EncodeWorker(MemoryPtr memory)
    : memory_(std::move(memory)), encoder_(memory_->room(MemoryUse::encoded)),
      thread_([this] { run(); }) {}

EncodeWorker::~EncodeWorker() {
    stop();
}

std::size_t EncodeWorker::submit_streamed(Job job, const KeyframeTiles& tiles) {
    const sea::KeyframePtr& keyframe = tiles.keyframe;
    Line left_out; // what jobs hold is released outside the lock
    {
        const std::lock_guard lock(mutex_);
        if (stopping_)
            return 1;
        if (streamed_.size() >= streamed_waiting_max)
            leave_out_the_oldest(left_out);
        Waiting next{std::move(job), keyframe};
        next.quality = tiles.quality;
        next.rank = tiles.rank;
        bring_forward(tiles);
        if (const Waiting* same = another_of(next.of)) {
            next.place = same->place;
            next.arrived = same->arrived;
        } else {
            next.arrived = ++arrived_;
            while (keyframe != nullptr &&
                   !(next.place = memory_->room(MemoryUse::encoding)->take(keyframe->bytes()))) {
                if (streamed_.empty())
                    return left_out.size() + 1;
                leave_out_the_oldest(left_out);
            }
        }
        const auto later = std::ranges::upper_bound(streamed_, next.rank, {}, &Waiting::rank);
        streamed_.insert(later, std::move(next));
    }
    wake_.notify_one();
    return left_out.size();
}

const EncodeWorker::Waiting* EncodeWorker::another_of(const sea::KeyframePtr& keyframe) const {
    if (keyframe == nullptr)
        return nullptr;
    if (encoded_now_ != nullptr && encoded_now_->of == keyframe)
        return encoded_now_;
    const auto found = std::ranges::find(streamed_, keyframe, &Waiting::of);
    return found == streamed_.end() ? nullptr : &*found;
}

void EncodeWorker::bring_forward(const KeyframeTiles& tiles) {
    for (Waiting& one : streamed_)
        if (tiles.keyframe != nullptr && one.of != nullptr && one.quality == tiles.quality &&
            one.of->cascade == tiles.keyframe->cascade)
            one.rank = std::min(one.rank, tiles.rank);
    std::ranges::stable_sort(streamed_, {}, &Waiting::rank);
}

void EncodeWorker::leave_out_the_oldest(Line& left_out) {
    const std::uint64_t first = std::ranges::min_element(streamed_, {}, &Waiting::arrived)->arrived;
    const auto rest =
        std::stable_partition(streamed_.begin(), streamed_.end(),
                              [first](const Waiting& one) { return one.arrived != first; });
    for (auto one = rest; one != streamed_.end(); ++one)
        one->place = nullptr; // at once: the room is for what comes
    const auto before = static_cast<std::ptrdiff_t>(left_out.size());
    left_out.resize(left_out.size() +
                    static_cast<std::size_t>(streamed_.end() - rest)); // or nothing is lost
    std::move(rest, streamed_.end(), left_out.begin() + before);
    streamed_.erase(rest, streamed_.end());
}

bool EncodeWorker::submit_fetched(Job job) {
    return submit(fetched_, fetches_waiting_max, std::move(job));
}

bool EncodeWorker::submit_start(Job job) {
    return submit(starts_, starts_waiting_max, std::move(job));
}

bool EncodeWorker::submit(Line& line, std::size_t waiting_max, Job job) {
    {
        const std::lock_guard lock(mutex_);
        if (stopping_ || line.size() >= waiting_max)
            return false;
        line.push_back({.job = std::move(job)});
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
    const bool others = !starts_.empty() || !fetched_.empty();
    const bool owed = !streamed_.empty() && owed_s_ > 0; // starts do not wait for that
    const bool goes_ahead = ahead_ < stream_slices_ahead || (owed && starts_.empty());
    if (!streamed_.empty() && (!others || goes_ahead))
        return &streamed_;
    if (!others)
        return nullptr;
    return fetched_.empty() || ((starts_turn_ || owed) && !starts_.empty()) ? &starts_ : &fetched_;
}

EncodeWorker::Waiting EncodeWorker::take_from(Line& line) {
    if (&line != &streamed_) {
        ahead_ = 0;
        starts_turn_ = &line == &fetched_;
    } else if (!starts_.empty() || !fetched_.empty()) {
        ++ahead_;
    }
    Waiting next = std::move(line.front());
    line.pop_front();
    return next;
}

void EncodeWorker::note_took(const Line& line, double seconds) {
    if (&line == &streamed_)
        owed_s_ -= seconds;
    else if (&line == &fetched_)
        owed_s_ = seconds > counted_slice_s ? stream_slices_ahead * seconds : 0.0;
}

void EncodeWorker::run() {
    name_thread("sea-encoder");
    std::unique_lock lock(mutex_);
    auto trim_at = std::chrono::steady_clock::now() + trims_every;
    while (true) {
        Line* line = nullptr;
        const auto called = [&] { return stopping_ || (line = next_line()) != nullptr; };
        if (encoder_.remembers())
            wake_.wait_until(lock, trim_at, called);
        else
            wake_.wait(lock, called);
        if (stopping_)
            return;
        if (const auto now = std::chrono::steady_clock::now(); now >= trim_at) {
            trim_at = now + trims_every;
            lock.unlock();
            encoder_.trim();
            lock.lock();
            continue; // what was called for may have been left out meanwhile
        }
        if (line == nullptr)
            continue;
        Waiting next = take_from(*line);
        encoded_now_ = &next;
        lock.unlock();
        bool done = true; // also where there is no memory for it
        const double start_s = thread_cpu_seconds();
        try {
            done = next.job(encoder_);
        } catch (const std::bad_alloc&) {
        }
        const double took_s = thread_cpu_seconds() - start_s;
        lock.lock();
        encoded_now_ = nullptr;
        note_took(*line, took_s);
        try {
            if (!done && !stopping_)
                line->push_front(std::move(next));
        } catch (const std::bad_alloc&) { // whose job it was is told by its end
        }
        lock.unlock();
        next = {}; // what it holds is released outside the lock
        lock.lock();
    }
}

} // namespace seaway::server
