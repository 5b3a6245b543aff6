// SPDX-License-Identifier: Apache-2.0
#include "tests/server/net/simulated/crowd.h"

#include <latch>
#include <list>

#include <spdlog/spdlog.h>

#include "tests/server/net/simulated/seat.h"

namespace seaway::tests::simulated {
namespace {

namespace limits = protocol::limits;

constexpr std::size_t seats_max = 24;
constexpr std::size_t points_most = 300; ///< that a peer asks for at once
/// Larger than the messages of `points_most` answers, of a refusal and of any other reply.
constexpr std::size_t reply_bytes_most = points_most * sizeof(wire::PointAnswer) + 512;

server::NetOptions options_by(Draw& draw, LateSea& sea) {
    server::NetOptions options;
    options.wrong_tokens_per_address = 0; // which counts by the real clock
    sea.holds(static_cast<std::size_t>(draw.log_uniform(2e4, 2e7)));
    return options;
}

class Crowd {
  public:
    explicit Crowd(std::uint64_t seed) : draw_(seed) {
        sea_.on_given = [this] { settle(); };
        offers_spectra_ = draw_.below(3) != 0;
        offer_spectrum();
        if (draw_.below(3) == 0)
            core_->tokens.client = token_ = "open";
    }

    Outcome live() {
        const int steps = draw_.whole(200, 1200);
        for (int i = 0; i < steps && !judge_.broken(); ++i)
            step();
        if (!judge_.broken())
            calm_down();
        if (!judge_.broken())
            leave();
        return {judge_.broken() ? judge_.story() : std::string(), judge_.seen(), judge_.digest()};
    }

  private:
    void step();
    void something_happens();
    void publish();
    void announce();
    void offer_spectrum();
    void leap();
    void run_posted(std::size_t most);
    void settle();
    void come_to(sea::TimeUs now_us);
    template <class Act>
    void alone(Seat& seat, const char* what, Act act);
    void sweep();
    void check();
    void check_counters();
    std::size_t bytes_allowed() const;
    void calm_down();
    void leave();
    void tell(const std::string& what) {
        judge_.tell(fmt::format("{:.3f} s {}", 1e-6 * static_cast<double>(now_us_), what));
    }

    Judge judge_;
    Draw draw_;
    LateSea sea_{draw_};
    std::mutex mutex_; ///< of posted_
    server::Turns::Clock::time_point turns_clock_;
    std::deque<server::Core::Work> posted_;
    std::shared_ptr<server::Core> core_ = std::make_shared<server::Core>(
        options_by(draw_, sea_), sea_,
        [this](server::Core::Work work) {
            const std::lock_guard lock(mutex_);
            posted_.push_back(std::move(work));
        },
        [this] { // each look at this clock finds it later, so turns end after some sessions
            return turns_clock_ += std::chrono::microseconds(30);
        });
    std::string token_;
    Publications publications_;
    std::map<int, std::map<server::Quality, std::uint64_t>>
        newest_turn_; ///< by cascade and quality
    std::uint64_t turn_ = 0;
    std::size_t keyframe_bytes_ = 0; ///< of the largest so far
    bool offers_spectra_ = false;
    std::size_t spectrum_bytes_ = 0; ///< of the largest so far
    sea::TimeUs now_us_ = 0;
    int seats_taken_ = 0;
    std::list<Seat> seats_;
};

// ---- what happens --------------------------------------------------------------------------

void Crowd::step() {
    const std::string name = fmt::format("client {}", seats_taken_ + 1);
    if (seats_.size() < seats_max && draw_.below(8) == 0) {
        ++seats_taken_;
        seats_.emplace_back(*core_, judge_, draw_, publications_, name, token_,
                            [this] { settle(); });
        tell(fmt::format("{} comes, temper {}", name, static_cast<int>(seats_.back().temper())));
    }
    for (Seat& seat : seats_)
        alone(seat, "acts", [&] { seat.act(); });
    something_happens();
    while (sea_.asked() && draw_.below(3) != 0)
        sea_.answer_one();
    run_posted(draw_.below(12));
    come_to(now_us_ + draw_.whole(1000, 40'000));
}

void Crowd::something_happens() {
    const std::uint64_t event = draw_.below(120);
    if (event < 25)
        publish();
    else if (event == 30)
        announce();
    else if (event == 31)
        leap();
    else if (event == 32)
        sea_.is_busy = !sea_.is_busy;
    else if (event == 33)
        sea_.lacks[static_cast<int>(draw_.below(2))] =
            sea::FieldSet::from_bits(static_cast<std::uint32_t>(draw_.below(1u << 13)) &
                                     static_cast<std::uint32_t>(draw_.below(1u << 13)));
    else if (event == 34)
        for (int i = 0; i < 20; ++i)
            announce();
    if (event < 35 || event > 39 || seats_.empty())
        return;
    auto at = seats_.begin();
    std::advance(at, draw_.below(seats_.size()));
    if (at->lost())
        return;
    alone(*at, "leaves or stalls", [&] {
        if (event == 35)
            at->cut();
        else if (event == 36)
            at->say_bye();
        else if (event == 37)
            at->set_rate(0);
        else
            at->set_rate(draw_.log_uniform(1e3, 1e8));
    });
}

/// As NetServer does it: each quality that somebody wants is encoded, and given to all who have it.
void Crowd::publish() {
    ++sea_.newest;
    for (int cascade = 0; cascade < 2; ++cascade)
        for (const server::Quality quality : {server::Quality{0}, server::Quality{1}}) {
            const sea::FieldSet wanted = core_->host.subscriptions().wanted(cascade, quality);
            if (wanted.empty())
                continue;
            const auto job = [this, wanted,
                              tiles = sea_.streamed(cascade, quality)](server::Encoder& encoder) {
                const auto encoded =
                    encoder.encode(*tiles.keyframe, tiles.codec_error, tiles.quality, wanted);
                core_->post([this, keyframe = *encoded] {
                    publications_[keyframe->number] = {++turn_, keyframe->quality,
                                                       keyframe->cascade, keyframe->fields,
                                                       keyframe->epoch};
                    newest_turn_[keyframe->cascade][keyframe->quality] = turn_;
                    keyframe_bytes_ = std::max(keyframe_bytes_, keyframe->bytes);
                    for (Seat& seat : seats_)
                        if (server::Session* session = core_->find(seat.session().id()))
                            session->deliver({keyframe, nullptr,
                                              core_->host.sea_state_message(keyframe->epoch)});
                });
                return true;
            };
            judge_.require(core_->encoding.submit_streamed(job) == 0, "there is a place to encode");
            settle();
        }
}

void Crowd::announce() {
    sea_.states = {SmallSea::state_message(++sea_.epoch)};
    offer_spectrum();
    for (Seat& seat : seats_) {
        seat.is_owed(sea_.states.front());
        if (server::Session* session = core_->find(seat.session().id()))
            alone(seat, "is told of a sea", [&] { session->announce(sea_.states.front()); });
        settle();
    }
}

/// Of the sea that runs and the one before, as long as both may be asked for.
void Crowd::offer_spectrum() {
    if (!offers_spectra_)
        return;
    std::vector<server::EncodedSpectrumPtr> spectra = sea_.spectra;
    spectra.push_back(
        SmallSea::spectrum_of(sea_.epoch, 1 + static_cast<std::uint32_t>(draw_.below(30))));
    spectrum_bytes_ = std::max(spectrum_bytes_, spectra.back()->bytes);
    if (spectra.size() > limits::spectra_max)
        spectra.erase(spectra.begin());
    sea_.offer_spectra(spectra);
}

/// The process was asleep, or somebody set the clock of the sea; backward there is a new sea.
void Crowd::leap() {
    tell("a leap of the clock");
    const bool back = draw_.below(2) == 0;
    sea_.newest += back ? -draw_.whole(1, 1000) : draw_.whole(1, 1'000'000);
    if (back)
        announce();
    come_to(now_us_ + draw_.whole(0, 15'000'000));
}

// ---- how it goes on ------------------------------------------------------------------------

/// The encoder has done what it was given: what it posts comes in the same order on every run.
void Crowd::settle() {
    std::latch done(4);
    const auto last = [&done](server::Encoder&) {
        done.count_down();
        return true;
    };
    const bool taken = core_->encoding.submit_streamed(last) == 0 &&
                       core_->encoding.submit_fetched(last) && core_->encoding.submit_start(last) &&
                       core_->spectra.submit_start(last);
    judge_.require(taken, "the encoder takes what little there is");
    done.wait();
}

void Crowd::run_posted(std::size_t most) {
    for (std::size_t i = 0; i < most; ++i) {
        server::Core::Work work;
        {
            const std::lock_guard lock(mutex_);
            if (posted_.empty())
                return;
            work = std::move(posted_.front());
            posted_.pop_front();
        }
        work();
    }
}

void Crowd::come_to(sea::TimeUs now_us) {
    now_us_ = now_us;
    for (Seat& seat : seats_)
        alone(seat, "lives on", [&] { seat.come_to(now_us_); });
    sweep();
    check();
}

/// What happens to one session ends no other one.
template <class Act>
void Crowd::alone(Seat& seat, const char* what, Act act) {
    const std::size_t before = core_->sessions.size();
    const bool was_there = !seat.session().ended();
    act();
    const bool is_there = !seat.session().ended();
    judge_.require(core_->sessions.size() + (was_there && !is_there ? 1u : 0u) == before,
                   fmt::format("when {} {}, nobody else is ended", seat.name(), what));
}

void Crowd::sweep() {
    for (auto at = seats_.begin(); at != seats_.end();)
        at = at->lost() ? seats_.erase(at) : std::next(at);
}

// ---- what is promised ----------------------------------------------------------------------

/// Replies that may wait for one session: it is read from while there are fewer than so many, and is then
/// owed those of what is under way; a Subscribe has two.
constexpr std::size_t replies_allowed = limits::replies_waiting_max + 1 +
                                        limits::queries_in_flight_max +
                                        2 * std::size_t{limits::fetches_in_flight_max};

/// What may wait for one session (server/publish/outbox.h, protocol/limits.h).
std::size_t Crowd::bytes_allowed() const {
    const std::size_t states = limits::durable_waiting_max * sea_.states.front()->size();
    const std::size_t streamed = 4 * keyframe_bytes_; // one a cascade of each of two seas
    const std::size_t spectra = limits::spectra_max * spectrum_bytes_;
    // A start holds two keyframes of two cascades, without a place in the room of fetches.
    const std::size_t side = static_cast<std::size_t>(sea_.size);
    const std::size_t map_bytes = side * side * sizeof(float) + 512;
    const std::size_t start = 4 * static_cast<std::size_t>(sea_.offered.size()) * map_bytes;
    const std::size_t fetched = core_->memory->share(server::MemoryUse::fetched) + start / 4;
    return replies_allowed * reply_bytes_most + states + streamed + spectra +
           static_cast<std::size_t>(limits::fetches_in_flight_max) * start + fetched;
}

void Crowd::check() {
    const std::size_t allowed = bytes_allowed();
    for (const auto& [id, session] : core_->sessions) {
        const std::size_t waiting = session->outbox().bytes_waiting();
        judge_.require(waiting <= allowed, fmt::format("what waits for a session is bounded: {} of "
                                                       "{} bytes",
                                                       waiting, allowed));
    }
    for (const Seat& seat : seats_)
        judge_.require(
            seat.session().ended() || seat.ledger().replies_owed() <= replies_allowed,
            fmt::format("requests are taken while replies can be sent: {}", seat.ledger().owing()));
    judge_.require(core_->host.subscriptions().size() <= core_->sessions.size(),
                   "only sessions have subscriptions");
    check_counters();
}

void Crowd::check_counters() {
    const server::Counters& counters = core_->counters;
    std::uint64_t closed = 0;
    for (const auto& [reason, count] : counters.sessions_closed)
        closed += count;
    judge_.require(counters.sessions_opened == static_cast<std::uint64_t>(seats_taken_),
                   "every session is counted once when it opens");
    judge_.require(counters.sessions_opened - closed == core_->sessions.size(),
                   "every session is counted once when it ends");
    server::OutboxCounters outboxes = counters.outboxes;
    for (const auto& [id, session] : core_->sessions)
        outboxes += session->outbox().counters();
    const std::map<std::string, std::uint64_t>& seen = judge_.seen();
    const auto counted = [&](const char* what, std::uint64_t count) {
        const auto found = seen.find(what);
        judge_.require(count == (found == seen.end() ? 0 : found->second),
                       fmt::format("each {} is counted once", what));
    };
    counted("keyframe begun", outboxes.keyframes_started);
    counted("message handed out", counters.messages_sent);
    counted("message taken", counters.messages_received);
}

/// No more is asked; all links are fast, all keyframes acknowledged, all questions answered.
void Crowd::calm_down() {
    tell("all calm down");
    sea_.is_busy = false;
    sea_.lacks.clear();
    const auto quiet = [this] {
        for (int i = 0; i < 40; ++i) {
            while (sea_.asked())
                sea_.answer_one();
            run_posted(~std::size_t{0});
            come_to(now_us_ + 100'000);
        }
    };
    for (Seat& seat : seats_)
        seat.calm_down();
    quiet();
    publish();
    quiet();
    for (const Seat& seat : seats_) {
        if (!seat.session().greeted() || seat.session().ended())
            continue;
        judge_.count("was there to the end");
        judge_.require(seat.ledger().owes_nothing(),
                       "who asks is answered: " + seat.ledger().owing());
        judge_.require(seat.session().outbox().bytes_waiting() == 0, "nothing waits for ever");
        const auto grant = core_->host.subscriptions().find(seat.session().id());
        for (int cascade = 0; grant && cascade < 2; ++cascade)
            if (grant->wants(cascade))
                judge_.require(seat.ledger().newest(cascade) ==
                                   newest_turn_[cascade][grant->quality],
                               seat.name() + ": the newest keyframe always arrives");
    }
}

void Crowd::leave() {
    for (Seat& seat : seats_)
        if (draw_.below(2) == 0)
            seat.say_bye();
        else if (server::Session* session = core_->find(seat.session().id()))
            session->close(wire::ErrorCode::shutting_down, "the server stops");
    for (int i = 0; i < 5; ++i)
        come_to(now_us_ + 1'000'000);
    seats_.clear();
    run_posted(~std::size_t{0});
    sea_.forget_questions();
    settle();
    judge_.require(core_->sessions.empty(), "every session has ended");
    judge_.require(sea_.subscriptions().size() == 0, "nobody is subscribed who is gone");
    judge_.require(core_->memory->room(server::MemoryUse::fetched)->held_bytes() == 0,
                   "no fetched tile is held");
    judge_.require(core_->memory->room(server::MemoryUse::replies)->held_bytes() == 0,
                   "no answer is held");
    judge_.require(sea_.keyframes_held() == 0, "no keyframe is held");
    const std::weak_ptr<server::Core> core = core_;
    core_->encoding.stop();
    core_->spectra.stop();
    core_->detach();
    core_ = nullptr;
    judge_.require(core.expired(), "nobody holds the core");
}

} // namespace

Outcome live_through(std::uint64_t seed) {
    spdlog::set_level(spdlog::level::off);
    return Crowd(seed).live();
}

} // namespace seaway::tests::simulated
