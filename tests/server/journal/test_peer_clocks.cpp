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

/// Half of two ways of 500 to 800 us, and what clocks may run apart in the second (and one trip) that passes between two looks.
constexpr double most_off_us = 800 + 1'500 + 10;

/// Servers whose seas are ahead of the true one by so much, each with a steady clock from somewhere.
class Fleet {
  public:
    Fleet(std::vector<std::int64_t> ahead_us, std::int64_t delay_us, std::int64_t jitter_us,
          std::uint64_t seed = 1)
        : ahead_us_(std::move(ahead_us)), delay_us_(delay_us), jitter_us_(jitter_us),
          random_(seed) {
        for (std::size_t i = 0; i < ahead_us_.size(); ++i)
            clocks_.push_back(std::make_unique<PeerClocks>(fmt::format("server{}", i)));
    }

    void run(std::int64_t seconds) {
        for (const std::int64_t end_us = now_us_ + seconds * 1'000'000; now_us_ < end_us;
             now_us_ += 100) {
            for (std::size_t i = 0; i < clocks_.size(); ++i)
                if ((now_us_ + static_cast<std::int64_t>(i) * 137'000) % PeerClocks::every_us == 0)
                    say(i);
            std::erase_if(under_way_, [this](const Word& word) {
                if (word.due_us > now_us_)
                    return false;
                clocks_[word.to]->hear(word.text, local(word.to));
                return true;
            });
        }
    }
    PeersSeen seen(std::size_t i) const { return clocks_[i]->seen(local(i), sea(i)); }
    void silence(std::size_t i) { silent_ = i; }
    std::size_t longest_word() const { return longest_word_; }

  private:
    struct Word {
        std::int64_t due_us;
        std::size_t to;
        std::string text;
    };
    std::int64_t local(std::size_t i) const {
        return now_us_ + 1'000'000'000 * static_cast<std::int64_t>(i + 1);
    }
    std::int64_t sea(std::size_t i) const { return now_us_ + ahead_us_[i]; }
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
        // By its own sea's time each, which runs 0.4 ms a second slow.
        const std::int64_t sea_us = 1000 * ms - 1000 * ms / 2500;
        for (const auto& [from, word] : std::exchange(under_way, {}))
            for (std::size_t to = 0; to < 3; ++to)
                all[to]->hear(word, sea_us + lag_us);
        for (std::size_t from = 0; from < 3; ++from)
            if ((ms + 300 * static_cast<std::int64_t>(from)) % 1000 == 0)
                under_way.emplace_back(from, all[from]->word(sea_us, sea_us));
        if (ms <= 5000 || ms % 1000 != 500)
            continue;
        for (const PeerClocks* one : all)
            ASSERT_LE(std::abs(one->seen(sea_us, sea_us).ahead_us), 1000) << ms;
    }
}

TEST(PeerClocks, a_word_of_a_megabyte_and_numbers_at_the_ends_are_nothing) {
    PeerClocks clocks("a");
    std::string longest = "seaway-clock-1 b 1 1\n";
    while (longest.size() < 1'000'000)
        longest += "a 1 1\n";
    clocks.hear(longest, 5);
    EXPECT_EQ(clocks.seen(6, 6).peers, 0);
    for (const char* numbers :
         {"-9223372036854775808 9223372036854775807", "9223372036854775807 -9223372036854775808",
          "0 9223372036854775807", "-9223372036854775808 0"})
        for (const char* sea : {"-9223372036854775808", "9223372036854775807", "7"})
            clocks.hear(std::string("seaway-clock-1 b 1 ") + sea + "\na " + numbers + "\n", 5);
    EXPECT_EQ(clocks.seen(6, 6).peers, 0);
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

// As of servers that are started again and again: each start has another name, and says nothing more.
TEST(PeerClocks, any_number_of_names_takes_no_more_places_and_none_from_who_answers) {
    PeerClocks clocks("me");
    const auto said_back = [](const std::string& name, std::int64_t now_us) {
        return fmt::format("seaway-clock-1 {} 5 1000\nme {} 2\n", name, now_us - 10);
    };
    clocks.hear(said_back("real1", 1000), 1000);
    clocks.hear(said_back("real2", 1000), 1000);
    for (int i = 0; i < 10'000; ++i)
        clocks.hear(fmt::format("seaway-clock-1 gone{} 5 1000\n", i), 2000 + i);
    EXPECT_EQ(clocks.seen(20'000, 0).peers, 2);
    // Where all have answered, the one that was heard first goes.
    PeerClocks full("me");
    for (std::size_t i = 0; i < PeerClocks::peers_max + 36; ++i) {
        const auto now_us = static_cast<std::int64_t>(1000 + i);
        full.hear(said_back(fmt::format("peer{}", i), now_us), now_us);
    }
    EXPECT_EQ(full.seen(3000, 0).peers, static_cast<int>(PeerClocks::peers_max));
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
    clocks.hear(word + "me 10 2\n", 20);
    EXPECT_EQ(clocks.seen(20, 0).peers, 1);
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
        clocks.hear(word, 20);
    EXPECT_EQ(clocks.seen(20, 0).peers, 0);
    PeerClocks crowded("me");
    for (int i = 0; i < 2000; ++i)
        crowded.hear(fmt::format("seaway-clock-1 flood{} 5 1000\nme 10 2\n", i), 20);
    EXPECT_EQ(crowded.seen(20, 0).peers, static_cast<int>(PeerClocks::peers_max));
    PeerClocks other("me");
    other.hear(good, 20);
    EXPECT_EQ(other.seen(20, 0).peers, 1);
}

} // namespace
} // namespace seaway::server
