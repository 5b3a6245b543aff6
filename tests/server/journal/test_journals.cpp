// SPDX-License-Identifier: Apache-2.0
// What every journal promises, wherever it is kept.
#include <gtest/gtest.h>

#include "tests/server/journal/journals.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;

template <class Kind>
class Journals : public testing::Test {
  protected:
    const JournalPlace place_ = Kind::fresh();

    std::unique_ptr<Journal> open(const Beginning& with = beginning) const {
        Result<std::unique_ptr<Journal>> journal = open_journal(place_, with);
        EXPECT_TRUE(journal) << (journal ? "" : journal.error().message);
        return journal ? *std::move(journal) : nullptr;
    }
};
using Kinds = testing::Types<InAFolder, InNats>;
TYPED_TEST_SUITE(Journals, Kinds);

TYPED_TEST(Journals, hold_the_instant_and_every_change_and_say_the_same_when_opened_again) {
    std::vector<SeaChange> all{{1, 0, 0, beginning.scene}};
    {
        const auto journal = this->open();
        ASSERT_TRUE(journal);
        EXPECT_EQ(journal->epoch_utc_us(), beginning.epoch_utc_us);
        for (std::uint32_t epoch = 2; epoch < 6; ++epoch) {
            all.push_back(change(epoch));
            const auto taken = journal->append(all.back());
            ASSERT_TRUE(taken) << taken.error().message;
            EXPECT_EQ(journal->standing().last_epoch, epoch);
        }
        EXPECT_EQ(journal->since(0).value(), all);
    }
    const auto again = this->open({99, "another sea"});
    ASSERT_TRUE(again);
    EXPECT_EQ(again->epoch_utc_us(), beginning.epoch_utc_us);
    EXPECT_EQ(again->since(0).value(), all);
    EXPECT_EQ(again->since(3).value(), std::vector<SeaChange>(all.begin() + 3, all.end()));
    EXPECT_TRUE(again->since(5)->empty());
    EXPECT_TRUE(again->since(99)->empty());
    EXPECT_EQ(again->standing().last_epoch, 5u);
    EXPECT_TRUE(again->standing().current);
}

TYPED_TEST(Journals, keep_any_text_of_a_scene_byte_by_byte) {
    std::string scene(200'000, 'x');
    for (std::size_t i = 0; i < scene.size(); ++i)
        scene[i] = static_cast<char>(i * 31 % 256); // with NUL, quotes and what is no UTF-8
    ASSERT_TRUE(this->open({0, scene}));
    const auto again = this->open();
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->since(0).value()[0].scene == scene);
}

TYPED_TEST(Journals, keep_how_fast_the_sea_runs_among_its_changes) {
    const std::vector<SeaChange> all{
        {1, 0, 0, beginning.scene},
        {.epoch = 2, .scene = {}, .pace = sea::Pace{-5, 1'234'567'890'123'456, 0}},
        change(3),
        {.epoch = 4, .scene = {}, .pace = sea::Pace{9, 8, sea::pace_permille_max}}};
    {
        const auto journal = this->open();
        ASSERT_TRUE(journal);
        for (std::size_t i = 1; i < all.size(); ++i)
            ASSERT_TRUE(journal->append(all[i]));
    }
    EXPECT_EQ(this->open()->since(0).value(), all);
}

TYPED_TEST(Journals, take_no_change_out_of_turn) {
    const auto journal = this->open();
    ASSERT_TRUE(journal);
    ASSERT_TRUE(journal->append(change(2)));
    const SeaChange wrong[] = {change(2),
                               change(4),
                               change(1),
                               change(0),
                               {3, 3'000'000, 2'999'999, "ends before it begins"},
                               {3, 3'000'000, 3'000'000, "takes no time"}};
    for (const SeaChange& one : wrong) {
        const auto refused = journal->append(one);
        ASSERT_FALSE(refused) << one.epoch;
        EXPECT_NE(refused.error().message.find(journal->name()), std::string::npos);
        EXPECT_NE(refused.error().message.find(one.epoch == 3 ? "from 3000000" : "epoch"),
                  std::string::npos)
            << refused.error().message;
    }
    // What no time of a sea is would be computed with by every server that follows.
    constexpr sea::TimeUs ever = sea::time_us_max, beyond = ever + 1;
    const SeaChange untimely[] = {{3, 0, beyond, "ends beyond"},
                                  {3, -beyond, 0, "begins beyond"},
                                  {.epoch = 3, .scene = {}, .pace = sea::Pace{beyond, 0, 500}},
                                  {.epoch = 3, .scene = {}, .pace = sea::Pace{0, -beyond, 500}}};
    for (const SeaChange& one : untimely) {
        const auto refused = journal->append(one);
        ASSERT_FALSE(refused);
        EXPECT_NE(refused.error().message.find("no time of a sea"), std::string::npos)
            << refused.error().message;
    }
    EXPECT_EQ(journal->since(0)->size(), 2u);
    EXPECT_TRUE(journal->append({3, -ever, ever, "as long as can be"}));
    EXPECT_TRUE(journal->append({4, 1, 2, "takes over from one that has not begun"}));
}

} // namespace
} // namespace seaway::server
