// SPDX-License-Identifier: Apache-2.0
#include "server/publish/outbox.h"

#include <algorithm>

namespace seaway::server {

namespace limits = protocol::limits;
using protocol::SharedBytes;

Outbox::Streamed Outbox::Parcel::streamed() const {
    if (keyframe == nullptr || keyframe->place == nullptr)
        return {};
    return {keyframe->number, keyframe->bytes};
}

SharedBytes Outbox::Parcel::take() {
    if (done != nullptr)
        return std::exchange(done, nullptr);
    if (keyframe == nullptr)
        return nullptr;
    while (map < keyframe->maps.size()) {
        const EncodedField& encoded = keyframe->maps[map];
        const auto& parts =
            differs && !encoded.differences.empty() ? encoded.differences : encoded.parts;
        if (fields.contains(encoded.field) && part < parts.size())
            return {keyframe, parts[part++].get()}; // keeps the keyframe's place
        ++map;
        part = 0;
    }
    keyframe = nullptr;
    file = nullptr;
    return nullptr;
}

Outbox::Run Outbox::Parcel::taken() const {
    if (file == nullptr || file->differs != differs)
        return {};
    const std::vector<std::uint64_t>& at = file->at[map];
    return {file, at[part - 1], at[part]};
}

void Outbox::push_reply(SharedBytes message) {
    reply_bytes_ += message->size();
    replies_.push_back(std::move(message));
}

bool Outbox::accepts_requests() const {
    return replies_.size() < limits::replies_waiting_max &&
           reply_bytes_ < limits::replies_bytes_max;
}

bool Outbox::push_durable(SharedBytes message) {
    if (durable_.size() >= limits::durable_waiting_max)
        return false;
    durable_.push_back(std::move(message));
    return true;
}

void Outbox::push_spectrum(EncodedSpectrumPtr spectrum) {
    std::erase_if(spectra_, [&](const SpectrumParcel& waiting) {
        return waiting.spectrum->epoch == spectrum->epoch;
    });
    for (SpectrumParcel& before : spectra_) { // who could wait would let this one wait
        before.bytes_per_s = 0;
        before.allowed_bytes = std::numeric_limits<std::size_t>::max();
    }
    spectra_.push_back({std::move(spectrum)});
    if (spectra_.size() > limits::spectra_max)
        spectra_.pop_front();
}

void Outbox::push_paced_spectrum(EncodedSpectrumPtr spectrum, sea::TimeUs now_us) {
    const double left_s = sea::seconds_from_us(spectrum->whole_by_us - now_us);
    const auto bytes = static_cast<double>(spectrum->bytes);
    const bool later = spectrum->whole_by_us > now_us;
    push_spectrum(std::move(spectrum));
    if (!later)
        return;
    spectra_.back().begun_us = now_us;
    spectra_.back().bytes_per_s = std::max(limits::spectrum_bytes_per_s, bytes / left_s);
    allow_spectra(now_us);
}

void Outbox::allow_spectra(sea::TimeUs now_us) {
    for (SpectrumParcel& parcel : spectra_)
        if (parcel.bytes_per_s > 0)
            parcel.allowed_bytes = static_cast<std::size_t>(
                1 +
                parcel.bytes_per_s * std::max(sea::seconds_from_us(now_us - parcel.begun_us), 0.0));
}

bool Outbox::paces_spectra() const {
    return std::ranges::any_of(spectra_,
                               [](const SpectrumParcel& one) { return one.bytes_per_s > 0; });
}

bool Outbox::spectrum_waiting() const {
    return std::ranges::any_of(spectra_,
                               [](const SpectrumParcel& one) { return one.bytes_per_s == 0; });
}

bool Outbox::push_fetched(std::span<const EncodedKeyframePtr> keyframes, sea::FieldSet fields,
                          SharedBytes done) {
    std::size_t bytes = fetched_bytes_ + done->size();
    for (const EncodedKeyframePtr& keyframe : keyframes)
        bytes += message_bytes(*keyframe, fields);
    if (bytes > limits::fetch_bytes_max)
        return false;
    fetched_bytes_ = bytes;
    for (const EncodedKeyframePtr& keyframe : keyframes)
        fetched_.push_back({.keyframe = keyframe, .fields = fields, .done = nullptr});
    fetched_.push_back({.keyframe = nullptr, .fields = {}, .done = std::move(done)});
    ++fetches_waiting_;
    return true;
}

void Outbox::push_keyframe(EncodedKeyframePtr keyframe, sea::FieldSet fields,
                           KeyframeFilePtr file) {
    SEAWAY_CHECK(keyframe->cascade >= 0 && keyframe->cascade < limits::cascades_max,
                 "cascade number out of range");
    if (unacknowledged_.size() >= static_cast<std::size_t>(credit_))
        ++counters_.keyframes_awaiting_credit;
    Parcel parcel{.keyframe = keyframe, .fields = fields, .done = nullptr, .file = std::move(file)};
    if (is_next_step(*keyframe, fields))
        waiting_.push_back(std::move(parcel));
    else
        replace(std::move(parcel));
}

void Outbox::replace(Parcel parcel) {
    const EncodedKeyframe& keyframe = *parcel.keyframe;
    // Of each of two seas: where one follows another both are streamed for a while.
    std::vector<std::uint32_t> epochs;
    for (const Parcel& one : waiting_)
        if (one.keyframe->cascade == keyframe.cascade &&
            std::ranges::find(epochs, one.keyframe->epoch) == epochs.end())
            epochs.push_back(one.keyframe->epoch);
    const bool same_sea = std::ranges::find(epochs, keyframe.epoch) != epochs.end();
    const std::uint32_t gone = same_sea || epochs.size() < 2 ? keyframe.epoch : epochs.front();
    const auto goes = [&, cascade = keyframe.cascade](const Parcel& one) {
        return one.keyframe->cascade == cascade && one.keyframe->epoch == gone;
    };
    const auto first = std::ranges::find_if(waiting_, goes);
    if (first == waiting_.end()) {
        waiting_.push_back(std::move(parcel));
        return;
    }
    *first = std::move(parcel); // keeps its turn
    const auto others = std::remove_if(std::next(first), waiting_.end(), goes);
    counters_.keyframes_replaced += 1 + static_cast<std::uint64_t>(waiting_.end() - others);
    waiting_.erase(others, waiting_.end());
}

std::uint64_t Outbox::last_streamed(const EncodedKeyframe& like) const {
    for (const Last& one : last_streamed_)
        if (one.epoch == like.epoch && one.cascade == like.cascade)
            return one.number;
    return 0;
}

bool Outbox::is_next_step(const EncodedKeyframe& keyframe, sea::FieldSet fields) const {
    if (keyframe.base == 0 || !fields.contains(predicted_fields))
        return false;
    std::uint64_t reached = last_streamed(keyframe);
    std::size_t bytes = message_bytes(keyframe, fields, true);
    std::size_t steps = 1;
    for (const Parcel& one : waiting_) {
        if (one.keyframe->cascade != keyframe.cascade || one.keyframe->epoch != keyframe.epoch)
            continue;
        if (one.keyframe->base != reached)
            return false;
        reached = one.keyframe->number;
        bytes += message_bytes(*one.keyframe, one.fields, true);
        ++steps;
    }
    // Each keeps a whole keyframe in memory, too: who reads nothing is not to hold many of those.
    if (steps > limits::steps_waiting_max)
        return false;
    return reached == keyframe.base && bytes < message_bytes(keyframe, fields);
}

void Outbox::set_credit(int keyframes) {
    SEAWAY_CHECK(keyframes >= limits::credit_min && keyframes <= limits::credit_max,
                 "credit out of range");
    credit_ = keyframes;
}

void Outbox::stop_stream() {
    waiting_.clear();
    last_streamed_.clear();
}

void Outbox::clear() noexcept {
    replies_.clear();
    durable_.clear();
    spectra_.clear();
    fetched_.clear();
    stop_stream();
    unacknowledged_.clear();
    reply_bytes_ = fetched_bytes_ = 0;
    fetches_waiting_ = 0;
    begun_ = {};
    sent();
    last_run_ = {};
}

bool Outbox::acknowledge(std::uint64_t keyframe) {
    return std::erase(unacknowledged_, keyframe) > 0;
}

SharedBytes Outbox::next() {
    last_run_ = {};
    SharedBytes message = next_message();
    if (message == nullptr)
        return nullptr;
    if (handed_out_++ == 0)
        run_ = std::move(last_run_);
    else if (run_.of != nullptr && run_.of == last_run_.of && run_.end == last_run_.begin)
        run_.end = last_run_.end;
    else
        run_ = {};
    return message;
}

SharedBytes Outbox::next_message() {
    if (!replies_.empty()) {
        SharedBytes message = std::move(replies_.front());
        replies_.pop_front();
        reply_bytes_ -= message->size();
        return message;
    }
    if (!durable_.empty()) {
        SharedBytes message = std::move(durable_.front());
        durable_.pop_front();
        return message;
    }
    if (SharedBytes message = next_spectrum())
        return message;
    fetched_turn_ = !fetched_turn_;
    SharedBytes message = fetched_turn_ ? next_fetched() : next_streamed();
    if (message == nullptr)
        message = fetched_turn_ ? next_streamed() : next_fetched();
    return message;
}

SharedBytes Outbox::next_spectrum() {
    if (spectra_.empty())
        return nullptr;
    SpectrumParcel& first = spectra_.front();
    if (first.bytes >= first.allowed_bytes)
        return nullptr;
    SharedBytes message = first.spectrum->messages[first.next++];
    first.bytes += message->size();
    if (first.next == first.spectrum->messages.size())
        spectra_.pop_front();
    return message;
}

SharedBytes Outbox::take_of(Parcel& parcel) {
    const Streamed of = parcel.streamed();
    SharedBytes message = parcel.take();
    if (message != nullptr && being_sent_.number == 0)
        being_sent_ = of;
    if (message != nullptr)
        last_run_ = parcel.taken();
    return message;
}

SharedBytes Outbox::next_fetched() {
    while (!fetched_.empty()) {
        const bool last = fetched_.front().done != nullptr;
        if (SharedBytes message = take_of(fetched_.front())) {
            fetched_bytes_ -= message->size();
            if (last) {
                fetched_.pop_front();
                --fetches_waiting_;
            }
            return message;
        }
        fetched_.pop_front();
    }
    return nullptr;
}

void Outbox::begin(Parcel& parcel) {
    const EncodedKeyframe& keyframe = *parcel.keyframe;
    const bool can_follow = parcel.fields.contains(predicted_fields);
    parcel.differs = can_follow && keyframe.base != 0 && keyframe.base == last_streamed(keyframe);
    std::erase_if(last_streamed_, [&](const Last& one) {
        return one.epoch == keyframe.epoch && one.cascade == keyframe.cascade;
    });
    if (!can_follow)
        return;
    if (last_streamed_.size() >= 2 * limits::cascades_max)
        last_streamed_.pop_front();
    last_streamed_.push_back({keyframe.epoch, keyframe.cascade, keyframe.number});
}

SharedBytes Outbox::next_streamed() {
    if (SharedBytes message = take_of(begun_))
        return message;
    while (!waiting_.empty() && unacknowledged_.size() < static_cast<std::size_t>(credit_)) {
        begun_ = std::move(waiting_.front());
        waiting_.pop_front();
        begin(begun_);
        const std::uint64_t number = begun_.keyframe->number;
        const bool leads_on = std::ranges::any_of(waiting_, [this](const Parcel& later) {
            return later.keyframe->cascade == begun_.keyframe->cascade &&
                   later.keyframe->epoch == begun_.keyframe->epoch;
        });
        SharedBytes message = take_of(begun_);
        if (message == nullptr) // holds nothing that the session was granted
            continue;
        if (!leads_on) // a step on the way to a newer one goes with that
            unacknowledged_.push_back(number);
        ++counters_.keyframes_started;
        counters_.keyframes_predicted += begun_.differs ? 1 : 0;
        return message;
    }
    return nullptr;
}

Outbox::Streamed Outbox::oldest_streamed() const {
    Streamed oldest = being_sent_;
    const auto look = [&oldest](const Parcel& parcel) {
        const Streamed one = parcel.streamed();
        if (one.number != 0 && (oldest.number == 0 || one.number < oldest.number))
            oldest = one;
    };
    look(begun_);
    std::ranges::for_each(waiting_, look);
    std::ranges::for_each(fetched_, look);
    return oldest;
}

std::size_t Outbox::bytes_waiting() const {
    std::size_t bytes = reply_bytes_ + fetched_bytes_;
    for (const SharedBytes& message : durable_)
        bytes += message->size();
    for (const SpectrumParcel& parcel : spectra_)
        for (std::size_t n = parcel.next; n < parcel.spectrum->messages.size(); ++n)
            bytes += parcel.spectrum->messages[n]->size();
    for (const Parcel& parcel : waiting_)
        bytes += message_bytes(*parcel.keyframe, parcel.fields);
    return bytes;
}

} // namespace seaway::server
