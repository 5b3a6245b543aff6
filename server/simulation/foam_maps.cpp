// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/foam_maps.h"

#include <limits>
#include <utility>

#include "base/undo.h"

namespace seaway::server {

FoamMaps::FoamMaps(SeaCoursePtr course) : course_(std::move(course)), epochs_(course_->epochs()) {
    const RunningSea& sea = *course_->first();
    if (!sea.foam_law)
        return;
    for (std::size_t c = 0; c < sea.realization->cascades.size(); ++c) {
        histories_.push_back(
            {sea.realization->cascades[c].spec.size,
             sea::FoamWalk(sea.foam_law, static_cast<int>(c), sea.budget.cascades[c].interval_us),
             nullptr});
        histories_.back().walk.follow(
            [followed = course_](sea::TimeUs time_us) {
                return followed->at(time_us)->foam_law_at(time_us);
            },
            false);
        look_for_changes(static_cast<int>(c));
    }
}

void FoamMaps::look_for_changes(int cascade) {
    if (course_->epochs() > 1)
        histories_[static_cast<std::size_t>(cascade)].walk.may_change();
}

void FoamMaps::follow_changes() {
    const std::uint32_t known = std::exchange(epochs_, course_->epochs());
    for (std::uint32_t epoch = known + 1; epoch <= epochs_; ++epoch)
        for (History& history : histories_)
            if (history.walk.is_past(course_->window(epoch).start_us))
                history.walk.restart();
}

FoamMaps::History& FoamMaps::history(int cascade) {
    SEAWAY_CHECK(!histories_.empty(), "foam is offered only where the scene has a law for it");
    History& found = histories_[static_cast<std::size_t>(cascade)];
    if (found.lost()) {
        found.map = nullptr;
        found.walk.restart();
    }
    return found;
}

int FoamMaps::ticks_to(int cascade, sea::TimeUs time_us) const {
    const History& history = histories_[static_cast<std::size_t>(cascade)];
    if (!history.lost())
        return history.walk.ticks_to(time_us);
    sea::FoamWalk anew = history.walk;
    anew.restart();
    return anew.ticks_to(time_us);
}

bool FoamMaps::is_near(int cascade, sea::TimeUs time_us) const {
    const History& history = histories_[static_cast<std::size_t>(cascade)];
    const std::optional<sea::TimeUs> next_us = history.walk.next_us(time_us);
    return !history.lost() && (!next_us || *next_us >= time_us);
}

Result<void> FoamMaps::own(History& history, KeyframeMaker& device) {
    if (history.map != nullptr && history.map.use_count() == 1)
        return {};
    Result<FoamMapPtr> opened = device.open_foam(history.size, history.map.get());
    if (opened)
        history.map = std::move(*opened);
    else
        history.walk.restart();
    return opened ? Result<void>() : Result<void>(opened.error());
}

Result<bool> FoamMaps::walk(KeyframeMaker& device, int cascade, sea::TimeUs time_us, int ticks_max,
                            sea::TimeUs until_us, const IsThere& is_there) {
    SEAWAY_CHECK(ticks_max >= 1, "every slice goes some way");
    History& own_history = history(cascade);
    const auto waits = [&] {
        const std::optional<sea::TimeUs> next_us = own_history.walk.next_us(time_us);
        return next_us && *next_us <= until_us;
    };
    const auto may_look = [&] {
        const std::optional<sea::TimeUs> next_us = own_history.walk.next_us(time_us);
        return !next_us || !is_there || is_there(*next_us);
    };
    constexpr int calm_per_tick = 8; // whose law is looked at, and no more
    const int calm_max = ticks_max > std::numeric_limits<int>::max() / calm_per_tick
                             ? std::numeric_limits<int>::max()
                             : calm_per_tick * ticks_max;
    int passed = 0;
    while (passed < calm_max && may_look() && own_history.walk.pass_calm(time_us, 1) == 1)
        ++passed;
    if (!waits())
        return true;
    if (passed == calm_max || !may_look())
        return false;
    SEAWAY_TRY(own(own_history, device));
    Undo steps([&own_history] { own_history.walk.restart(); }); // what it counts is not taken yet
    std::vector<FoamTurn> turns;
    std::vector<sea::TimeUs> times_us;
    while (static_cast<int>(turns.size()) < ticks_max && waits() && may_look()) {
        const std::optional<sea::FoamStep> step = own_history.walk.next(time_us);
        if (!step) // a change was added meanwhile, and it is calm
            break;
        turns.push_back({own_history.map.get(), step->tick, {}});
        times_us.push_back(step->time_us);
    }
    std::vector<KeyframeRequest> requests;
    for (std::size_t i = 0; i < turns.size(); ++i)
        requests.push_back(
            {cascade, times_us[i], {}, course_->window_at(times_us[i]).epoch, &turns[i]});
    SEAWAY_TRY(device.synthesize(requests));
    steps.keep();
    return !waits();
}

Result<FoamTurn> FoamMaps::turn(KeyframeMaker& device, int cascade, sea::TimeUs time_us) {
    SEAWAY_CHECK(is_near(cascade, time_us), "a history is walked to before its map is shown");
    History& own_history = history(cascade);
    FoamTurn turn;
    own_history.walk.pass_calm(time_us, 1);
    if (own_history.walk.next_us(time_us)) {
        SEAWAY_TRY(own(own_history, device));
        if (const std::optional<sea::FoamStep> step = own_history.walk.next(time_us))
            turn.kept = step->tick;
    }
    if (own_history.map == nullptr)
        SEAWAY_TRY(own(own_history, device));
    turn.map = own_history.map.get();
    turn.shown = own_history.walk.at(time_us);
    return turn;
}

Result<std::vector<NewKeyframePtr>> FoamMaps::synthesize(KeyframeMaker& device,
                                                         std::vector<KeyframeRequest> requests) {
    std::vector<FoamTurn> turns(requests.size());
    Undo steps([&] {
        for (const KeyframeRequest& request : requests)
            if (request.fields.contains(sea::Field::foam))
                restart(request.cascade);
    });
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const int cascade = requests[i].cascade;
        const sea::TimeUs time_us = requests[i].time_us;
        if (!requests[i].fields.contains(sea::Field::foam))
            continue;
        constexpr int all = std::numeric_limits<int>::max();
        look_for_changes(cascade);
        SEAWAY_TRY(walk_near(device, cascade, time_us, all));
        SEAWAY_TRY_LET(turns[i], turn(device, cascade, time_us));
        requests[i].foam = &turns[i];
    }
    SEAWAY_TRY_LET(std::vector<NewKeyframePtr> made, device.synthesize(requests));
    steps.keep();
    return made;
}

} // namespace seaway::server
