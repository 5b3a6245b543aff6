// SPDX-License-Identifier: Apache-2.0
// LateSea: a small sea that answers when it is told to, part by part, or refuses; and knows which of
// what it has handed out is still held by somebody.
#pragma once

#include <deque>
#include <list>

#include "tests/server/simulation/small_sea.h"
#include "tests/support/draw.h"

namespace seaway::tests::simulated {

class LateSea final : public SmallSea {
  public:
    /// Streamed keyframes lie at whole multiples of the interval, fetched ones in the middle between
    /// them: so a tile says which of both it is.
    static bool is_streamed(sea::TimeUs time_us) { return time_us % interval_us == 0; }

    explicit LateSea(Draw& draw) : draw_(draw) { size = 1 << draw.whole(1, 4); }

    std::uint32_t epoch = 0;
    std::function<void()> on_given; ///< after something was given to be encoded

    KeyframeTiles streamed(int cascade, server::Quality quality) {
        return made(cascade, newest * interval_us, held(cascade), quality);
    }

    void fetch(server::FetchRequest request, Fetched done) override {
        Question question{.asker = request.asker, .fetched = std::move(done)};
        std::set<sea::TimeUs> times;
        for (const sea::TimeUs time_us : request.times_us)
            times.insert(time_us - time_us % interval_us + interval_us / 2);
        if (times.empty())
            times = {newest * interval_us - interval_us / 2,
                     newest * interval_us + interval_us / 2};
        const server::Quality rung = quality(request.demand);
        for (const sea::TimeUs time_us : times) {
            question.parts.emplace_back();
            for (int cascade = 0; cascade < 2; ++cascade)
                if (request.demand.wants(cascade))
                    question.parts.back().push_back(
                        made(cascade, time_us, request.demand.fields & held(cascade), rung));
        }
        ask(std::move(question));
    }
    void query(server::QueryBatch batch, Queried done) override {
        Question question{.asker = batch.asker, .queried = std::move(done)};
        question.answers.epoch = epoch;
        question.answers.answers.resize(batch.points.size());
        ask(std::move(question));
    }

    bool asked() const { return !questions_.empty(); }
    /// The next part of some answer.
    void answer_one() {
        auto at = questions_.begin();
        std::advance(at, draw_.below(questions_.size()));
        if (answer(*at))
            questions_.erase(at);
    }
    void forget_questions() { questions_.clear(); }

    /// Keyframes of this sea that somebody still holds.
    std::size_t keyframes_held() {
        std::erase_if(made_, [](const auto& keyframe) { return keyframe.expired(); });
        return made_.size();
    }

  private:
    struct Question {
        server::Asker asker;
        Fetched fetched = nullptr;
        Queried queried = nullptr;
        std::deque<std::vector<KeyframeTiles>> parts = {};
        server::QueryAnswers answers = {};
    };

    sea::FieldSet held(int cascade) const {
        const auto lacking = lacks.find(cascade);
        return lacking == lacks.end() ? offered : offered.without(lacking->second);
    }

    KeyframeTiles made(int cascade, sea::TimeUs time_us, sea::FieldSet fields,
                       server::Quality quality) {
        KeyframeTiles tiles = keyframe(cascade, time_us / interval_us, fields, quality);
        auto keyframe = std::make_shared<sea::Keyframe>(*tiles.keyframe);
        keyframe->time_us = time_us;
        keyframe->epoch = epoch;
        tiles.keyframe = std::move(keyframe);
        made_.push_back(tiles.keyframe);
        return tiles;
    }

    /// Some are answered before fetch() or query() has returned.
    void ask(Question question) {
        while (draw_.below(4) == 0)
            if (answer(question))
                return;
        questions_.push_back(std::move(question));
    }

    /// True: that was the end of it.
    bool answer(Question& question) {
        Error why{server::Refusal::busy, "later"};
        why.retry_after_ms = 7;
        const bool refused = question.asker.gone() || (is_busy && draw_.below(2) == 0);
        if (question.queried != nullptr) {
            question.queried(refused ? Result<server::QueryAnswers>(why) : question.answers);
            return true;
        }
        if (refused || question.parts.empty()) {
            question.fetched(why);
            on_given();
            return true;
        }
        server::FetchedPart part{.tiles = std::move(question.parts.front()), .last = false};
        question.parts.pop_front();
        part.last = question.parts.empty();
        const bool last = part.last;
        question.fetched(std::move(part));
        on_given();
        return last;
    }

    Draw& draw_;
    std::list<Question> questions_;
    std::vector<std::weak_ptr<const sea::Keyframe>> made_;
};

} // namespace seaway::tests::simulated
