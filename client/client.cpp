// SPDX-License-Identifier: Apache-2.0
#include "client/client.h"

#include <algorithm>
#include <condition_variable>
#include <future>

#include "client/link/failure.h"
#include "client/wanted.h"

namespace seaway::client {

using sea::Answer;
using sea::QueryPoint;
using sea::TimeUs;

namespace {

/// Sea states that are kept: the running one, those announced, and some of times that were asked about.
constexpr std::size_t sea_states_max = 32;
/// Glides that begin before the one before them has ended.
constexpr int glides_chained_max = 4;

/// A later epoch takes over from those that were to begin when it does, or after.
void drop_overtaken(std::vector<SeaStatePtr>& states) {
    std::erase_if(states, [all = states](const SeaStatePtr& state) {
        return std::ranges::any_of(all, [&state](const SeaStatePtr& other) {
            return other->epoch > state->epoch && other->start_time_us <= state->start_time_us;
        });
    });
}
/// Batches of one ask() under way: enough to hide the round trip.
constexpr std::size_t batches_in_flight = 4;

} // namespace

Client::Client(ClientEvents events, RingLimits limits)
    : events_(std::move(events)), ring_(limits) {}

Client::~Client() {
    connection_.reset();
}

Result<std::unique_ptr<Client>> Client::connect(const ConnectOptions& options, ClientEvents events,
                                                RingLimits limits) {
    std::unique_ptr<Client> client(new Client(std::move(events), limits));
    Result<std::unique_ptr<Connection>> connection =
        Connection::open(options, client->connection_events());
    if (!connection)
        return connection.error();
    client->connection_ = std::move(*connection);
    return client;
}

ConnectionEvents Client::connection_events() {
    ConnectionEvents events;
    events.on_sea_state = [this](const SeaStatePtr& state) {
        {
            const std::scoped_lock lock(mutex_);
            std::erase_if(sea_states_, [&](const SeaStatePtr& held) {
                if (held->epoch == state->epoch && held->probes != state->probes)
                    forget_waves(held->epoch);
                return held->epoch == state->epoch;
            });
            sea_states_.push_back(state);
            drop_overtaken(sea_states_);
            std::stable_sort(sea_states_.begin(), sea_states_.end(),
                             [](const SeaStatePtr& a, const SeaStatePtr& b) {
                                 return a->start_time_us < b->start_time_us;
                             });
            if (sea_states_.size() > sea_states_max) {
                forget_waves(sea_states_.front()->epoch);
                sea_states_.erase(sea_states_.begin());
            }
        }
        if (events_.on_sea_state)
            events_.on_sea_state(state);
    };
    events.on_keyframe = [this](const HeldKeyframePtr& keyframe) {
        ring_.insert(keyframe);
        {
            const std::scoped_lock lock(mutex_);
            for (Wanted* wanted : wanted_)
                wanted->offer(keyframe);
        }
        if (events_.on_keyframe)
            events_.on_keyframe(keyframe);
    };
    take_waves(events);
    events.on_grant = [this](const Grant& grant) {
        const std::scoped_lock lock(mutex_);
        grant_ = grant;
    };
    events.on_clock = [this](LocalUs sent_us, LocalUs received_us, TimeUs elapsed_us) {
        const std::scoped_lock lock(mutex_);
        clock_.add(sent_us, received_us, elapsed_us);
    };
    events.on_pace = [this](const sea::Pace& pace) {
        const std::scoped_lock lock(mutex_);
        paces_.add(pace);
    };
    events.on_closed = [this](const Error& reason) {
        {
            const std::scoped_lock lock(mutex_);
            end_ = reason;
        }
        if (events_.on_closed)
            events_.on_closed(reason);
    };
    return events;
}

void Client::take_waves(ConnectionEvents& events) {
    events.on_spectrum = [this](const SeaStatePtr& state, const protocol::SpectrumHead& head) {
        const auto begun = std::make_shared<ReceivedSpectrum>(state, head);
        const std::scoped_lock lock(mutex_);
        std::erase_if(received_, [&](const auto& held) { // of seas that are over
            return std::ranges::none_of(
                sea_states_, [&](const SeaStatePtr& known) { return known->epoch == held.first; });
        });
        received_[state->epoch] = begun;
    };
    events.on_waves = [this](std::uint32_t epoch, const sea::SpectrumLeft& left,
                             std::span<const sea::WaveBlock> blocks) -> Result<void> {
        std::shared_ptr<ReceivedSpectrum> spectrum;
        {
            const std::scoped_lock lock(mutex_);
            if (const auto found = received_.find(epoch); found != received_.end())
                spectrum = found->second;
        }
        return spectrum ? spectrum->add(left, blocks) : Result<void>(); // its sea is over
    };
}

void Client::forget_waves(std::uint32_t epoch) {
    rebuilt_.erase(epoch);
    received_.erase(epoch);
    glides_.erase(epoch);
}

std::optional<Error> Client::end() const {
    const std::scoped_lock lock(mutex_);
    return end_;
}

std::string Client::closed_reason() const {
    const std::optional<Error> why = end();
    return why ? why->message : std::string();
}

std::optional<Grant> Client::grant() const {
    const std::scoped_lock lock(mutex_);
    return grant_;
}

TimeUs Client::now_us() {
    const std::scoped_lock lock(mutex_);
    const TimeUs elapsed_us = clock_.now(local_now_us());
    paces_.forget_before(elapsed_us);
    // A pace that was heard of late changes what follows, not what was shown.
    shown_us_ = std::max(shown_us_, paces_.sea_time(elapsed_us));
    return shown_us_;
}

ClockStatus Client::clock() const {
    const std::scoped_lock lock(mutex_);
    return clock_.status(local_now_us());
}

SeaStatePtr Client::sea_state(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    return sea_state_held(time_us);
}

SeaStatePtr Client::sea_state_held(TimeUs time_us) const {
    SeaStatePtr running = sea_states_.front();
    for (const SeaStatePtr& state : sea_states_)
        if (state->start_time_us <= time_us)
            running = state;
    return running;
}

sea::FieldSet Client::offered(sea::FieldSet fields) const {
    const std::scoped_lock lock(mutex_);
    return sea::FieldSet::from_bits(fields.bits() & ~not_offered_.bits());
}

void Client::note_offer(sea::FieldSet asked, sea::FieldSet granted) {
    const std::scoped_lock lock(mutex_);
    const std::uint32_t missing = asked.bits() & ~granted.bits();
    not_offered_ = sea::FieldSet::from_bits((not_offered_.bits() & ~granted.bits()) | missing);
}

Result<Grant> Client::subscribe(const protocol::TileWish& wish, int credit, double timeout_s) {
    Waiter waiter;
    connection_->subscribe(wish, credit, timeout_s, waiter.handler());
    Result<Reply> reply = waiter.wait();
    if (!reply)
        return reply.error();
    note_offer(wish.fields, reply->grant.fields);
    return reply->grant;
}

Result<protocol::SpectrumGrant> Client::subscribe_spectrum(const protocol::SpectrumWish& wish,
                                                           double timeout_s) {
    Waiter waiter;
    connection_->subscribe_spectrum(wish, timeout_s, waiter.handler());
    Result<Reply> reply = waiter.wait();
    if (!reply)
        return reply.error();
    std::vector<std::shared_ptr<ReceivedSpectrum>> spectra;
    {
        const std::scoped_lock lock(mutex_);
        for (const auto& [epoch, spectrum] : received_)
            spectra.push_back(spectrum);
    }
    for (const auto& spectrum : spectra) {
        const RebuiltSeaPtr waves = spectrum->sea();
        if (spectrum->state()->glide) // probes are of the sea that it leads to
            continue;
        if (const Result<void> same = waves ? agrees(*spectrum->state(), *waves) : Result<void>();
            !same) {
            const std::scoped_lock lock(mutex_);
            received_.erase(spectrum->state()->epoch);
            return same.error();
        }
    }
    return reply->spectrum;
}

Result<std::vector<Answer>> Client::ask(std::span<const QueryPoint> points, const Asking& asking) {
    struct Progress {
        std::mutex mutex;
        std::condition_variable changed;
        std::size_t under_way = 0;
        std::vector<Answer> answers;
        std::optional<Error> problem;
    };
    const std::size_t batch_size = std::max(
        asking.exact ? welcome().exact_points_per_query_max : welcome().points_per_query_max, 1u);
    const auto progress = std::make_shared<Progress>();
    progress->answers.resize(points.size());
    std::unique_lock lock(progress->mutex);
    for (std::size_t first = 0; first < points.size(); first += batch_size) {
        progress->changed.wait(lock, [&] { return progress->under_way < batches_in_flight; });
        if (progress->problem)
            break;
        ++progress->under_way;
        lock.unlock();
        const auto batch = points.subspan(first, std::min(batch_size, points.size() - first));
        connection_->query(
            batch, asking.exact, asking.timeout_s, [progress, first](Result<Reply> reply) {
                const std::scoped_lock inner(progress->mutex);
                --progress->under_way;
                if (reply)
                    std::copy(reply->answers.begin(), reply->answers.end(),
                              progress->answers.begin() + static_cast<std::ptrdiff_t>(first));
                else if (!progress->problem)
                    progress->problem = reply.error();
                progress->changed.notify_all();
            });
        lock.lock();
    }
    progress->changed.wait(lock, [&] { return progress->under_way == 0; });
    if (progress->problem)
        return *progress->problem;
    return std::move(progress->answers);
}

Result<LocalSurface> Client::surface(TimeUs time_us) const {
    return local_surface(*sea_state(time_us), ring_, time_us, sampled_fields());
}

Result<std::vector<Answer>> Client::sample(std::span<const QueryPoint> points) const {
    return sample_from(ring_, points);
}

Result<void> Client::rebuild(TimeUs time_us) {
    const SeaStatePtr state = sea_state(time_us);
    SEAWAY_TRY_LET(const RebuiltSeaPtr made, rebuild_from_scene(*state));
    const std::scoped_lock lock(mutex_);
    for (const SeaStatePtr& held : sea_states_)
        if (held == state) // not replaced meanwhile
            rebuilt_[state->epoch] = made;
    return {};
}

OwnSeaPtr Client::own_sea(const SeaStatePtr& state) const {
    const std::scoped_lock lock(mutex_);
    return own_sea_held(state, glides_chained_max);
}

OwnSeaPtr Client::own_sea_held(const SeaStatePtr& state, int depth) const {
    if (const auto found = rebuilt_.find(state->epoch); found != rebuilt_.end())
        return found->second;
    const auto received = [&](std::uint32_t epoch) -> OwnSeaPtr {
        const auto found = received_.find(epoch);
        return found == received_.end() ? nullptr : found->second->sea();
    };
    const OwnSeaPtr waves = received(state->epoch);
    if (!state->glide) {
        if (waves)
            return waves;
        for (const SeaStatePtr& other : sea_states_) // its waves are those that a glide led to
            if (other->glide && other->glide->end_us == state->start_time_us)
                return received(other->epoch);
        return nullptr;
    }
    const SeaStatePtr before = sea_state_held(state->start_time_us - 1);
    if (!waves || depth == 0 || before == state)
        return nullptr;
    const OwnSeaPtr from = own_sea_held(before, depth - 1);
    if (!from)
        return nullptr;
    Glide& glide = glides_[state->epoch];
    if (glide.from != from || glide.to != waves) {
        const auto made =
            GlidingSea::create(*state, *from, *waves, state->start_time_us, state->glide->end_us);
        glide = {from, waves, made ? *made : nullptr};
    }
    return glide.sea;
}

std::size_t Client::answer_rebuilt(std::span<const QueryPoint> points, std::size_t first,
                                   std::span<Answer> answers) const {
    const SeaStatePtr state = sea_state(points[first].time_us);
    const OwnSeaPtr waves = own_sea(state);
    if (!waves)
        return first;
    std::size_t end = first + 1;
    while (end < points.size() && (points[end].time_us == points[first].time_us ||
                                   sea_state(points[end].time_us) == state))
        ++end;
    waves->answer(points.subspan(first, end - first), answers.subspan(first, end - first));
    return end;
}

Result<std::vector<Answer>> Client::sample_from(const KeyframeRing& ring,
                                                std::span<const QueryPoint> points) const {
    std::vector<Answer> answers(points.size());
    const sea::FieldSet fields = sampled_fields();
    SeaStatePtr state;
    TimeCell cell;
    std::optional<LocalSurface> surface;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const TimeUs time_us = points[i].time_us;
        if (const std::size_t end = answer_rebuilt(points, i, answers); end > i) {
            i = end - 1;
            continue;
        }
        if (!surface || time_us != points[i - 1].time_us) {
            const SeaStatePtr state_now = sea_state(time_us);
            TimeCell cell_now = time_cell(*state_now, time_us);
            if (!surface || state_now != state || cell_now != cell ||
                glides_choppiness(*state_now)) {
                Result<LocalSurface> found = local_surface(*state_now, ring, time_us, fields);
                if (!found)
                    return found.error();
                surface.emplace(std::move(*found));
                state = state_now;
                cell = std::move(cell_now);
            }
        }
        answers[i] = surface->surface.answer(points[i]);
        if (!surface->covers)
            answers[i].flags |= sea::answer_extrapolated;
    }
    return answers;
}

} // namespace seaway::client
