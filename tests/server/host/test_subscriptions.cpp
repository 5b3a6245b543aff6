// SPDX-License-Identifier: Apache-2.0
// Who wants what.
#include <set>

#include <gtest/gtest.h>

#include "server/host/asker.h"
#include "server/host/subscriptions.h"
#include "tests/support/allocations.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

TEST(Subscriptions, wanted_is_the_union_over_sessions_of_a_cascade_at_a_quality) {
    Subscriptions all;
    EXPECT_TRUE(all.wanted(0).empty());
    all.set(1, {.cascades = 1u, .fields = {Field::height}, .quality = 0});
    all.set(2, {.cascades = 3u, .fields = {Field::slope_x}, .quality = 2});
    all.set(3, {.cascades = 2u, .fields = {Field::foam}, .quality = 2});
    EXPECT_EQ(all.wanted(0), (FieldSet{Field::height, Field::slope_x}));
    EXPECT_EQ(all.wanted(1), (FieldSet{Field::slope_x, Field::foam}));
    EXPECT_TRUE(all.wanted(2).empty());
    EXPECT_EQ(all.wanted(0, 0), (FieldSet{Field::height}));
    EXPECT_TRUE(all.wanted(0, 1).empty()) << "nobody has this quality";
    EXPECT_EQ(all.wanted(0, 2), (FieldSet{Field::slope_x}));
    EXPECT_TRUE(all.wanted(1, 0).empty());
    EXPECT_EQ(all.find(3)->cascades, 2u);
    EXPECT_EQ(all.size(), 3u);

    all.set(2, {.cascades = 1u, .fields = {Field::slope_y}, .quality = 0});
    EXPECT_EQ(all.wanted(1), (FieldSet{Field::foam})) << "a later grant replaces the earlier one";
    all.erase(1);
    EXPECT_EQ(all.wanted(0, 0), (FieldSet{Field::slope_y}));
    EXPECT_FALSE(all.find(1));
    EXPECT_EQ(all.size(), 2u);
}

// Naive: what follows from maps that somebody else takes is wanted by nobody, and who takes nothing else gets nothing.
TEST(Subscriptions, what_follows_is_wanted_by_who_does_not_take_what_it_follows_from) {
    const FieldSet heights{Field::height, Field::height_rate};
    const FieldSet moved = sea::surface_fields.without(heights);
    Subscriptions all;
    all.set(1, {.cascades = 1u, .fields = sea::surface_fields});
    EXPECT_EQ(all.wanted(0, 0), sea::surface_fields);
    EXPECT_EQ(all.wanted(0, 0, moved), heights);
    all.set(2, {.cascades = 1u, .fields = {Field::displacement_x, Field::foam}});
    EXPECT_EQ(all.wanted(0, 0, moved), (heights | FieldSet{Field::displacement_x, Field::foam}));
}

TEST(Subscriptions, a_quality_is_in_use_for_as_long_as_somebody_has_it) {
    Subscriptions all;
    all.set(1, {.cascades = 1u, .fields = {Field::height}, .quality = 2});
    all.set(2, {.cascades = 3u, .fields = {Field::height}, .quality = 2});
    all.set(3, {.cascades = 1u, .fields = {Field::height}, .quality = 5});
    EXPECT_EQ(all.qualities(), std::bitset<quality_rungs>{}.set(2).set(5));
    EXPECT_EQ(all.most_wanted(1), std::vector<Quality>{2}) << "of a cascade";
    EXPECT_EQ(all.most_wanted(0), (std::vector<Quality>{2, 5}));
    all.set(4, {.cascades = 1u, .fields = {Field::height}, .quality = 5});
    all.set(5, {.cascades = 1u, .fields = {Field::height}, .quality = 5});
    EXPECT_EQ(all.most_wanted(0), (std::vector<Quality>{5, 2})) << "by readers";
    EXPECT_EQ(all.most_wanted(0, 1), (std::vector<Quality>{5, 2})) << "in whatever turn";
    all.set(6, {.cascades = 1u, .fields = {Field::height}, .quality = 7});
    all.erase(2);
    std::set<Quality>
        last; // naive: of those with as many readers the one with the highest number, always
    for (std::uint64_t turn = 0; turn < 3; ++turn)
        last.insert(all.most_wanted(0, turn).back());
    EXPECT_EQ(last, (std::set<Quality>{2, 7})) << "each in turn";
    all.erase(6);
    all.set(2, {.cascades = 3u, .fields = {Field::height}, .quality = 2});
    all.erase(4);
    all.erase(5);
    EXPECT_EQ(all.qualities_but(3), std::bitset<quality_rungs>{}.set(2)) << "but one";
    EXPECT_EQ(all.qualities_but(2), all.qualities()) << "another has it, too";
    EXPECT_EQ(all.qualities_but(9), all.qualities());
    all.set(3, {.cascades = 1u, .fields = {Field::slope_x}, .quality = 0});
    all.erase(1);
    EXPECT_EQ(all.qualities(), std::bitset<quality_rungs>{}.set(0).set(2));
    all.set(2, {});
    all.erase(2);
    all.erase(9);
    EXPECT_EQ(all.qualities(), std::bitset<quality_rungs>{}.set(0));
}

TEST(Subscriptions, what_those_want_who_go_without_a_field_is_theirs_alone_and_of_the_cascade) {
    Subscriptions all;
    all.set(1, {.cascades = 1u, .fields = {Field::height, Field::foam}, .quality = 0});
    all.set(2, {.cascades = 1u, .fields = {Field::slope_x}, .quality = 0});
    all.set(3, {.cascades = 2u, .fields = {Field::slope_y}, .quality = 1});
    all.set(4, {.cascades = 3u, .fields = {Field::displacement_x}, .quality = 2});
    EXPECT_EQ(all.wanted_without(0, Field::foam),
              (FieldSet{Field::slope_x, Field::displacement_x}));
    EXPECT_EQ(all.wanted_without(1, Field::foam),
              (FieldSet{Field::slope_y, Field::displacement_x}));
    EXPECT_EQ(all.wanted_without(0, Field::slope_x),
              (FieldSet{Field::height, Field::foam, Field::displacement_x}));
    EXPECT_TRUE(all.wanted_without(2, Field::foam).empty());
}

TEST(Subscriptions, an_empty_grant_is_none_and_only_changes_are_told) {
    Subscriptions all;
    int changes = 0;
    all.on_change([&] { ++changes; });
    all.set(1, {.cascades = 0u, .fields = {Field::height}});
    all.set(1, {.cascades = 1u, .fields = {}});
    all.erase(7);
    EXPECT_EQ(changes, 0);
    EXPECT_EQ(all.size(), 0u);
    all.set(1, {.cascades = 1u, .fields = {Field::height}});
    EXPECT_EQ(changes, 1);
    all.set(1, {});
    EXPECT_EQ(changes, 2);
    EXPECT_EQ(all.size(), 0u);
}

// Naive: who has nothing is entered to be taken out again, and where there is no memory for that what comes behind it is left undone.
TEST(Subscriptions, to_take_away_a_grant_or_none_takes_no_memory) {
    Subscriptions all;
    all.set(1, {.cascades = 1u, .fields = {Field::height}});
    {
        const tests::NoMemoryOnce none(0);
        const tests::Allocations asked;
        all.erase(7);
        all.set(7, {});
        all.erase(1);
        all.erase(1);
        EXPECT_EQ(asked.count(), 0u);
    }
    EXPECT_EQ(all.size(), 0u);
    EXPECT_TRUE(all.qualities().none());
}

// Gone with the session, or with the question that was given up; who stays and asks about nothing in
// particular, never.
TEST(Askers, are_there_for_as_long_as_what_they_were_made_of) {
    for (const bool session_goes : {true, false})
        for (const bool question_goes : {true, false}) {
            auto session = std::make_shared<char>(), question = std::make_shared<char>();
            const Asker asker(session);
            const Asker about = asker.about(question);
            const Asker stays = Asker::who_stays();
            const Asker stays_about = stays.about(question);
            for (const Asker& one : {asker, about, stays, stays_about})
                EXPECT_FALSE(one.gone());
            EXPECT_TRUE(asker.same(about));
            EXPECT_TRUE(stays.same(stays_about));
            const std::shared_ptr<const void> elsewhere = std::make_shared<char>(1);
            for (const Asker& other : {stays, Asker(elsewhere)}) {
                EXPECT_FALSE(asker.same(other));
                EXPECT_FALSE(other.same(asker));
            }
            if (session_goes)
                session = nullptr;
            if (question_goes)
                question = nullptr;
            EXPECT_EQ(asker.gone(), session_goes);
            EXPECT_EQ(about.gone(), session_goes || question_goes);
            EXPECT_FALSE(stays.gone());
            EXPECT_EQ(stays_about.gone(), question_goes);
        }
}

} // namespace
} // namespace seaway::server
