// SPDX-License-Identifier: Apache-2.0
// Clocks of servers that hear each other, in a network whose delays are drawn by lot.
#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "server/journal/peer_clocks.h"

namespace seaway::server {
namespace {

/// Half of two ways of 500 to 800 us, and of what two oscillators may run apart while a word is held for a second.
constexpr double most_off_us = 800 + 100 + 10;

/// Servers whose seas are ahead of the true one by so much, each with a steady clock from somewhere.
class Fleet {
  public:
    Fleet(std::vector<std::int64_t> ahead_us, std::int64_t delay_us, std::int64_t jitter_us,
          std::uint64_t seed = 1)
        : ahead_us_(std::move(ahead_us)), delay_us_(delay_us), jitter_us_(jitter_us), random_(seed),
          rates_(ahead_us_.size(), 0.0) {
        for (std::size_t i = 0; i < ahead_us_.size(); ++i)
            clocks_.push_back(std::make_unique<PeerClocks>(fmt::format("server{}", i)));
    }

    void run(std::int64_t seconds) { run_us(seconds * 1'000'000); }
    void run_us(std::int64_t us) {
        for (const std::int64_t end_us = now_us_ + us; now_us_ < end_us; now_us_ += 100) {
            for (std::size_t i = 0; i < clocks_.size(); ++i)
                if ((now_us_ + static_cast<std::int64_t>(i) * 137'000) % PeerClocks::every_us == 0)
                    say(i);
            std::erase_if(under_way_, [this](const Word& word) {
                if (word.due_us > now_us_)
                    return false;
                clocks_[word.to]->hear(word.text, local(word.to), sea(word.to));
                return true;
            });
        }
    }
    /// Faster than true time, as parts of one.
    void pull(std::vector<double> rates) { rates_ = std::move(rates); }
    std::int64_t ahead_us(std::size_t i) const { return sea(i) - now_us_; }
    PeersSeen seen(std::size_t i) const { return clocks_[i]->seen(local(i)); }
    void silence(std::size_t i) { silent_ = i; }
    std::size_t longest_word() const { return longest_word_; }

  private:
    struct Word {
        std::int64_t due_us;
        std::size_t to;
        std::string text;
    };
    std::int64_t sea(std::size_t i) const {
        return now_us_ + ahead_us_[i] + std::llround(rates_[i] * static_cast<double>(now_us_));
    }
    std::int64_t local(std::size_t i) const {
        return now_us_ + 1'000'000'000 * static_cast<std::int64_t>(i + 1);
    }
    void say(std::size_t i) {
        if (silent_ == i)
            return;
        const std::string text = clocks_[i]->word(local(i), sea(i));
        longest_word_ = std::max(longest_word_, text.size());
        for (std::size_t to = 0; to < clocks_.size(); ++to)
            under_way_.push_back(
                {now_us_ + delay_us_ +
                     std::uniform_int_distribution<std::int64_t>(0, jitter_us_)(random_),
                 to, text});
    }

    std::vector<std::int64_t> ahead_us_;
    std::int64_t delay_us_, jitter_us_;
    std::mt19937_64 random_;
    std::vector<double> rates_;
    std::vector<std::unique_ptr<PeerClocks>> clocks_;
    std::vector<Word> under_way_;
    std::int64_t now_us_ = 0;
    std::size_t silent_ = 99;
    std::size_t longest_word_ = 0;
};

// All clocks were set to another second at once, as by a time server, and are pulled there: nobody is apart from anybody.
TEST(PeerClocks, servers_that_are_pulled_together_do_not_blame_one_another) {
    constexpr std::int64_t lag_us = 300;
    PeerClocks a("a"), b("b"), c("c");
    const std::vector<PeerClocks*> all{&a, &b, &c};
    std::vector<std::pair<std::size_t, std::string>> under_way;
    for (std::int64_t ms = 0; ms < 100'000; ++ms) {
        // Their seas run 0.4 ms a second slow.
        const std::int64_t now_us = 1000 * ms, sea_us = now_us - now_us / 2500;
        for (const auto& [from, word] : std::exchange(under_way, {}))
            for (std::size_t to = 0; to < 3; ++to)
                all[to]->hear(word, now_us + lag_us, sea_us + lag_us);
        for (std::size_t from = 0; from < 3; ++from)
            if ((ms + 300 * static_cast<std::int64_t>(from)) % 1000 == 0)
                under_way.emplace_back(from, all[from]->word(now_us, sea_us));
        if (ms <= 5000 || ms % 1000 != 500)
            continue;
        for (const PeerClocks* one : all)
            ASSERT_LE(std::abs(one->seen(now_us).ahead_us), 1000) << ms;
    }
}

TEST(PeerClocks, a_word_of_a_megabyte_and_numbers_at_the_ends_are_nothing) {
    PeerClocks clocks("a");
    std::string longest = "seaway-clock-1 b 1 1\n";
    while (longest.size() < 1'000'000)
        longest += "a 1 1\n";
    clocks.hear(longest, 5, 5);
    EXPECT_EQ(clocks.seen(6).peers, 0);
    for (const char* numbers :
         {"-9223372036854775808 9223372036854775807", "9223372036854775807 -9223372036854775808",
          "0 9223372036854775807", "-9223372036854775808 0"})
        for (const char* sea : {"-9223372036854775808", "9223372036854775807", "7"})
            clocks.hear(std::string("seaway-clock-1 b 1 ") + sea + "\na " + numbers + "\n", 5, 5);
    EXPECT_EQ(clocks.seen(6).peers, 0);
}

TEST(PeerClocks, of_three_the_one_that_is_off_knows_it_and_the_others_do_not_blame_themselves) {
    for (const std::int64_t off_us : {-200'000, -3'000, 3'000, 200'000}) {
        Fleet fleet({0, off_us, 0}, 500, 300);
        fleet.run(30);
        for (std::size_t i = 0; i < 3; ++i) {
            const PeersSeen seen = fleet.seen(i);
            EXPECT_EQ(seen.peers, 2);
            EXPECT_TRUE(seen.can_judge());
            const double truth_us = i == 1 ? static_cast<double>(off_us) : 0;
            EXPECT_NEAR(seen.ahead_us, truth_us, seen.error_us + 1) << i << ' ' << off_us;
            EXPECT_LT(seen.error_us, most_off_us);
        }
    }
}

TEST(PeerClocks, the_stated_error_holds_for_many_networks) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Fleet fleet({0, 1'000, -2'000, 7'000, 0}, static_cast<std::int64_t>(seed) * 1'000, 5'000,
                    seed);
        fleet.run(20);
        const double truth_us[] = {0, 1'000, -2'000, 7'000, 0}; // the middle one is 0
        for (std::size_t i = 0; i < 5; ++i)
            EXPECT_NEAR(fleet.seen(i).ahead_us, truth_us[i], fleet.seen(i).error_us) << seed;
    }
}

// Naive: what words take is measured by seas that run apart meanwhile; where ways are shorter than that, one comes back before it
// was sent.
TEST(PeerClocks, clocks_that_are_pulled_apart_see_each_other_all_the_while) {
    Fleet fleet({0, 0, 0}, 100, 50);
    fleet.pull({4e-4, -4e-4, 0});
    fleet.run(3);
    for (int s = 0; s < 12; ++s) {
        fleet.run(1);
        for (std::size_t i = 0; i < 3; ++i) {
            const PeersSeen seen = fleet.seen(i);
            EXPECT_EQ(seen.peers, 2) << i;
            // As of when they were last heard: a second ago, in which two may have run apart by 0.8 ms.
            EXPECT_NEAR(seen.ahead_us, static_cast<double>(fleet.ahead_us(i)), seen.error_us + 801);
            // All that a look allows, of ways that end at whole tenths of a millisecond.
            EXPECT_LT(seen.error_us, 2 * (150 + 100 + 100 + 10)) << i;
        }
    }
}

// It is held for a second by a clock that runs 0.1 ms fast in that, and away for a second by ours.
TEST(PeerClocks, two_oscillators_may_differ_about_how_long_a_word_was_away) {
    PeerClocks clocks("me");
    clocks.hear("seaway-clock-1 other 5 1000000\nme 1000 1000100\n", 1'001'050, 1'000'000);
    EXPECT_EQ(clocks.seen(1'001'050).peers, 1);
    clocks.hear("seaway-clock-1 third 5 1000000\nme 1000 1000900\n", 1'001'050, 1'000'000);
    EXPECT_EQ(clocks.seen(1'001'050).peers, 2) << "its machine corrects its clock";
    clocks.hear("seaway-clock-1 liar 5 1000000\nme 1000 1002000\n", 1'001'050, 1'000'000);
    EXPECT_EQ(clocks.seen(1'001'050).peers, 2) << "none that says so much";
}

// Naive: what a peer may have run off since its last word counts, so that what is certain comes and goes each second.
TEST(PeerClocks, what_is_certain_does_not_come_and_go_between_two_words) {
    Fleet fleet({0, 3'000, 0}, 200, 100);
    fleet.run(20);
    for (int step = 0; step < 60; ++step) {
        fleet.run_us(50'000);
        const PeersSeen seen = fleet.seen(1);
        EXPECT_GT(std::abs(seen.ahead_us) - seen.error_us, 1'600) << step; // the gale's budget
    }
}

TEST(PeerClocks, of_two_nobody_is_to_blame_and_alone_there_is_nothing_to_see) {
    Fleet two({0, 50'000}, 500, 100);
    two.run(10);
    EXPECT_FALSE(two.seen(0).can_judge());
    EXPECT_NEAR(two.seen(0).ahead_us, -25'000, 1'000) << "the middle of both";
    Fleet one({0}, 500, 100);
    one.run(10);
    EXPECT_EQ(one.seen(0).peers, 0);
    EXPECT_EQ(one.seen(0).ahead_us, 0);
}

TEST(PeerClocks, who_falls_silent_counts_no_more) {
    Fleet fleet({0, 80'000, 80'000}, 500, 100);
    fleet.run(10);
    EXPECT_NEAR(fleet.seen(0).ahead_us, -80'000, 1'000);
    fleet.silence(2);
    fleet.run(15);
    EXPECT_EQ(fleet.seen(0).peers, 1);
    EXPECT_FALSE(fleet.seen(0).can_judge());
}

// Naive: a server that is off and starts again has two voices for as long as its old name is remembered, and of three the two that are
// right find themselves beside three others.
TEST(PeerClocks, a_server_that_has_ended_judges_nobody_while_it_is_still_remembered) {
    Fleet fleet({0, 0, 50'000, 50'000}, 500, 100); // the last one is the third, by another name
    fleet.silence(3);
    fleet.run(10);
    fleet.silence(2); // it ends, and starts again
    fleet.run(3);
    const PeersSeen seen = fleet.seen(0);
    EXPECT_EQ(seen.peers, 3) << "sessions may be handed over to somebody";
    EXPECT_EQ(seen.judges, 2);
    EXPECT_TRUE(seen.can_judge());
    EXPECT_NEAR(seen.ahead_us, 0, most_off_us) << "one is right, one is not, and so is this one";
}

// As of servers that are started again and again: each start has another name, and says nothing more.
TEST(PeerClocks, any_number_of_names_takes_no_more_places_and_none_from_who_answers) {
    PeerClocks clocks("me");
    const auto said_back = [](const std::string& name, std::int64_t now_us) {
        return fmt::format("seaway-clock-1 {} 5 1000\nme {} 2\n", name, now_us - 10);
    };
    clocks.hear(said_back("real1", 1000), 1000, 1000);
    clocks.hear(said_back("real2", 1000), 1000, 1000);
    for (int i = 0; i < 10'000; ++i)
        clocks.hear(fmt::format("seaway-clock-1 gone{} 5 1000\n", i), 2000 + i, 2000 + i);
    EXPECT_EQ(clocks.seen(20'000).peers, 2);
    // Where all have answered, the one that was heard first goes.
    PeerClocks full("me");
    for (std::size_t i = 0; i < PeerClocks::peers_max + 36; ++i) {
        const auto now_us = static_cast<std::int64_t>(1000 + i);
        full.hear(said_back(fmt::format("peer{}", i), now_us), now_us, now_us);
    }
    EXPECT_EQ(full.seen(3000).peers, static_cast<int>(PeerClocks::peers_max));
}

// Words go from each to each: what stands in one must not grow with the fleet as well.
TEST(PeerClocks, in_a_large_fleet_each_is_measured_by_eight_as_well_as_in_a_small_one) {
    constexpr std::size_t servers = 40, off = 17;
    std::vector<std::int64_t> ahead_us(servers, 0);
    ahead_us[off] = 3'000;
    Fleet fleet(ahead_us, 500, 300);
    fleet.run(3); // all are heard in the first second, and answered in the second
    for (std::size_t i = 0; i < servers; ++i)
        EXPECT_GE(fleet.seen(i).peers, static_cast<int>(PeerClocks::answered_max)) << i;
    fleet.run(27); // longer than those count that were answered while few were known
    for (std::size_t i = 0; i < servers; ++i) {
        const PeersSeen seen = fleet.seen(i);
        EXPECT_EQ(seen.peers, static_cast<int>(PeerClocks::answered_max)) << i;
        EXPECT_NEAR(seen.ahead_us, i == off ? 3'000 : 0, seen.error_us + 1) << i;
        EXPECT_LT(seen.error_us, most_off_us) << i; // as of three
    }
    // Names of 8 letters and digits here, local times of 11 and sea times of 8: 42 bytes, and 30 for each that is answered.
    EXPECT_LE(fleet.longest_word(), 42 + 30 * PeerClocks::answered_max);
}

TEST(PeerClocks, who_comes_between_two_takes_the_place_of_one_that_then_counts_no_more) {
    Fleet fleet(std::vector<std::int64_t>(14, 0), 500, 300);
    fleet.silence(5);
    fleet.run(15);
    EXPECT_EQ(fleet.seen(6).peers, static_cast<int>(PeerClocks::answered_max));
    fleet.silence(99);
    fleet.run(15);
    for (std::size_t i = 0; i < 14; ++i) {
        EXPECT_EQ(fleet.seen(i).peers, static_cast<int>(PeerClocks::answered_max)) << i;
        EXPECT_LT(fleet.seen(i).error_us, most_off_us) << i;
    }
}

TEST(PeerClocks, an_older_server_that_answers_all_whom_it_hears_is_understood) {
    std::string word = "seaway-clock-1 other 5 1000\n";
    for (int i = 0; i < 64; ++i)
        word += fmt::format("{:022} 1764076800000000 999999\n", i);
    PeerClocks clocks("me");
    clocks.hear(word + "me 10 2\n", 20, 20);
    EXPECT_EQ(clocks.seen(20).peers, 1);
}

TEST(PeerClocks, words_that_are_none_change_nothing) {
    PeerClocks clocks("me");
    std::string good = "seaway-clock-1 other 5 1000\nme 10 2\n";
    for (const std::string& word :
         {std::string(), std::string("seaway-clock-2 other 5 1000\nme 10 2\n"),
          std::string("seaway-clock-1 o/ther 5 1000\nme 10 2\n"),
          std::string("seaway-clock-1 me 5 1000\nme 10 2\n"), std::string("seaway-clock-1 other"),
          std::string("seaway-clock-1 other 5 1000\nme 999999 2\n"),
          std::string("seaway-clock-1 other 5 1000\nme 10 -2\n"),
          std::string("seaway-clock-1 other 5 1000\nme 10 99\n"), std::string(1000, '\xff')})
        clocks.hear(word, 20, 20);
    EXPECT_EQ(clocks.seen(20).peers, 0);
    PeerClocks crowded("me");
    for (int i = 0; i < 2000; ++i)
        crowded.hear(fmt::format("seaway-clock-1 flood{} 5 1000\nme 10 2\n", i), 20, 20);
    EXPECT_EQ(crowded.seen(20).peers, static_cast<int>(PeerClocks::peers_max));
    PeerClocks other("me");
    other.hear(good, 20, 20);
    EXPECT_EQ(other.seen(20).peers, 1);
}

} // namespace
} // namespace seaway::server
