// SPDX-License-Identifier: Apache-2.0
// Questions without waiting, limits, state and sources, as seaway_engine.h promises them.
#include <poll.h>

#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/client/engine.h"

extern "C" seaway_code one_map_in_c(seaway_client* client, float* texels, size_t bytes,
                                    seaway_map* map);
extern "C" seaway_code one_question_in_c(seaway_client* client, seaway_answer* water);

namespace seaway {
namespace {

using tests::Engine;
using tests::eventually;

TEST_F(Engine, a_question_is_answered_while_the_program_goes_on) {
    Sea client(net->url());
    const std::vector<seaway_point> points = places(50);
    std::uint64_t question = 0;
    ASSERT_EQ(seaway_ask(client.handle(), points.data(), points.size(), 0, 60, &question),
              SEAWAY_OK);
    EXPECT_NE(question, 0u);
    pollfd waits{seaway_poll_descriptor(client.handle()), POLLIN, 0};
    ASSERT_GE(waits.fd, 0);
    seaway_event event = SEAWAY_SIZED(seaway_event);
    do { // what the status says may have changed first
        ASSERT_EQ(::poll(&waits, 1, 60'000), 1);
        ASSERT_EQ(seaway_poll(client.handle(), 0, &event), SEAWAY_OK);
        ASSERT_NE(event.kind, static_cast<std::uint32_t>(SEAWAY_NOTHING)) << "it was readable";
    } while (event.kind != SEAWAY_ANSWERED);
    EXPECT_EQ(event.question, question);
    std::vector<seaway_answer> answers(points.size());
    EXPECT_NE(refusal(seaway_take_answers(client.handle(), question, answers.data(), 1))
                  .find("50 points"),
              std::string::npos);
    ASSERT_EQ(seaway_take_answers(client.handle(), question, answers.data(), answers.size()),
              SEAWAY_OK);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(answers[i].height_m,
                  sea.truth({points[i].x_m, points[i].y_m, points[i].time_us}).height_m);
    EXPECT_NE(
        refusal(seaway_take_answers(client.handle(), question, answers.data(), 50)).find("taken"),
        std::string::npos);
    while (event.kind != SEAWAY_NOTHING)
        ASSERT_EQ(seaway_poll(client.handle(), 0, &event), SEAWAY_OK);
    EXPECT_EQ(::poll(&waits, 1, 0), 0) << "nothing is left to be told";
}

// Naive: a size that nobody set is believed, and GiB behind the struct are read.
TEST_F(Engine, a_size_that_no_struct_has_is_refused) {
    Sea client(net->url());
    seaway_wish wish = SEAWAY_SIZED(seaway_wish);
    for (const std::uint32_t size : {3u, 4097u, 0xccccccccu}) {
        wish.size = size;
        EXPECT_THAT(refusal(seaway_subscribe_to(client.handle(), &wish, nullptr)),
                    testing::HasSubstr(fmt::format("size is {}: it must be sizeof", size)));
    }
}

TEST_F(Engine, a_cascade_that_no_sea_has_is_refused) {
    Sea client(net->url());
    client.hold({asked_us});
    seaway_map_wish wish = map_wish();
    seaway_map map = SEAWAY_SIZED(seaway_map);
    for (const std::uint32_t beyond : {16u, 31u, 0xffffffffu}) {
        wish.cascade = beyond;
        EXPECT_THAT(refusal(seaway_get_map(client.handle(), &wish, nullptr, 0, &map)),
                    testing::HasSubstr(fmt::format("is {}: a sea has 16 at most", beyond)));
    }
}

// Naive: a program that counts cascades from 1 sails on still water, without a word.
TEST_F(Engine, cascades_that_the_sea_has_not_are_refused_by_name_whatever_is_held) {
    seaway_looking looking = SEAWAY_SIZED(seaway_looking);
    looking.cascades = 1u << 7;
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.looking = &looking;
    const std::vector<seaway_point> points = places(2);
    const double z_m[2] = {-1, -1};
    std::vector<seaway_answer> answers(points.size());
    std::vector<seaway_water> water(points.size());
    std::vector<seaway_below> below(points.size());
    Sea client(net->url());
    for (const int held : {0, 1, 2}) {
        if (held > 0)
            hold_sea(client, held == 1);
        const auto named = testing::HasSubstr("there is no cascade 7; the sea has 2");
        EXPECT_THAT(refusal(seaway_sample_as(client.handle(), &how, points.data(), points.size(),
                                             answers.data())),
                    named);
        EXPECT_THAT(refusal(seaway_sample_water(client.handle(), &looking, points.data(),
                                                points.size(), water.data(), sizeof(seaway_water))),
                    named);
        EXPECT_THAT(refusal(seaway_query_some(client.handle(), &looking, points.data(),
                                              points.size(), 0, 10, answers.data())),
                    named);
        if (held == 2) {
            EXPECT_THAT(
                refusal(seaway_sample_below(client.handle(), &looking, points.data(), z_m,
                                            points.size(), below.data(), sizeof(seaway_below))),
                named);
        }
    }
    looking.cascades = 1u << 7 | 1u; // beside one that it has
    EXPECT_EQ(seaway_sample_as(client.handle(), &how, points.data(), points.size(), answers.data()),
              SEAWAY_OK);
}

// Naive: whoever is furthest away says how near all of a batch are looked for, and one that is nowhere that all are found.
TEST_F(Engine, a_point_that_is_nowhere_takes_nothing_from_those_beside_it) {
    Sea client(net->url());
    hold_sea(client, false);
    std::vector<seaway_point> points = places(4);
    const std::vector<seaway_water> alone = water_at(client, nullptr, points);
    for (const double far : {HUGE_VAL, std::nan(""), 1e9}) {
        points[3].x_m = far;
        const std::vector<seaway_water> beside = water_at(client, nullptr, points);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_EQ(beside[i].displacement_m[0], alone[i].displacement_m[0]) << far;
            EXPECT_EQ(beside[i].displacement_error_m, alone[i].displacement_error_m) << far;
        }
    }
}

// Naive: the server says so, a round trip and a place among those that may be open later.
TEST_F(Engine, a_question_of_what_is_out_of_range_is_never_open) {
    Sea client(net->url());
    std::uint64_t question = 0;
    for (const seaway_point& point :
         {seaway_point{1e10, 2, asked_us}, seaway_point{1, 2, std::numeric_limits<int64_t>::max()}})
        for (int i = 0; i < 300; ++i)
            EXPECT_EQ(seaway_ask(client.handle(), &point, 1, 0, 60, &question),
                      SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(question, 0u);
}

TEST_F(Engine, a_question_is_pending_until_its_deadline_unless_it_is_cancelled) {
    sea.answer_queries = false;
    Sea client(net->url());
    const seaway_point point{1, 2, asked_us};
    seaway_answer answer{};
    std::uint64_t first = 0, second = 0;
    ASSERT_EQ(seaway_ask(client.handle(), &point, 1, 0, 60, &first), SEAWAY_OK);
    ASSERT_EQ(seaway_ask(client.handle(), &point, 1, 0, 0.2, &second), SEAWAY_OK);
    EXPECT_EQ(seaway_take_answers(client.handle(), first, &answer, 1), SEAWAY_PENDING);
    EXPECT_EQ(seaway_cancel(client.handle(), first), SEAWAY_OK);
    EXPECT_EQ(seaway_cancel(client.handle(), first), SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(seaway_take_answers(client.handle(), first, &answer, 1), SEAWAY_BAD_ARGUMENT);
    seaway_code code = SEAWAY_PENDING;
    EXPECT_TRUE(eventually([&] {
        code = seaway_take_answers(client.handle(), second, &answer, 1);
        return code != SEAWAY_PENDING;
    }));
    EXPECT_EQ(code, SEAWAY_DEADLINE);
    EXPECT_EQ(answer.error_m, 0) << "nothing is written";

    seaway_state state = SEAWAY_SIZED(seaway_state);
    ASSERT_EQ(seaway_get_state(client.handle(), &state), SEAWAY_OK);
    for (std::uint32_t i = 0; i < state.questions_max; ++i)
        ASSERT_EQ(seaway_ask(client.handle(), &point, 1, 0, 60, &first), SEAWAY_OK);
    EXPECT_NE(refusal(seaway_ask(client.handle(), &point, 1, 0, 60, &second), SEAWAY_REFUSED)
                  .find(std::to_string(state.questions_max)),
              std::string::npos);
    const std::vector<seaway_point> many(state.points_max + 1, point);
    EXPECT_NE(refusal(seaway_ask(client.handle(), many.data(), many.size(), 0, 60, &second))
                  .find(std::to_string(state.points_max)),
              std::string::npos);
    net->stop();
    EXPECT_TRUE(eventually([&] {
        code = seaway_take_answers(client.handle(), first, &answer, 1);
        return code != SEAWAY_PENDING;
    }));
    EXPECT_EQ(code, SEAWAY_LOST);
}

TEST_F(Engine, the_state_says_what_is_held_and_what_may_be_asked) {
    Sea client(net->url());
    seaway_state state = SEAWAY_SIZED(seaway_state);
    const auto look = [&] { return seaway_get_state(client.handle(), &state); };
    ASSERT_EQ(look(), SEAWAY_OK);
    EXPECT_EQ(state.state, static_cast<std::uint32_t>(SEAWAY_CONNECTED));
    EXPECT_EQ(state.source, static_cast<std::uint32_t>(SEAWAY_FROM_SERVER));
    EXPECT_EQ(state.cascades, 2u);
    EXPECT_EQ(state.epoch, tests::WaveSea::epoch);
    EXPECT_EQ(state.fields, 0u);
    EXPECT_EQ(state.points_max, 4096u);
    EXPECT_EQ(state.exact_points_max, 256u);
    EXPECT_EQ(state.credit_max, 8u);
    EXPECT_EQ(state.questions, 0u);
    client.subscribe();
    ASSERT_EQ(look(), SEAWAY_OK);
    EXPECT_EQ(state.fields, SEAWAY_SURFACE_FIELDS);
    EXPECT_EQ(state.cascades_sent, 3u);
    EXPECT_NEAR(state.error_m, 0.01, 1e-9) << "a float of it";

    seaway_cascade cascade = SEAWAY_SIZED(seaway_cascade);
    ASSERT_EQ(seaway_get_cascade(client.handle(), asked_us, 1, &cascade), SEAWAY_OK);
    EXPECT_EQ(cascade.grid, 32u);
    EXPECT_EQ(cascade.length_m, 29);
    EXPECT_EQ(cascade.interval_us, 100'000);
    EXPECT_EQ(cascade.choppiness_x, 1);
    EXPECT_NEAR(cascade.shortest_wave_m, 2 * 29.0 / 32, 1e-9) << "two points a wave";
    EXPECT_EQ(seaway_get_cascade(client.handle(), asked_us, 2, &cascade), SEAWAY_BAD_ARGUMENT);
}

/// Foam and nothing else, of as many times the mean as cascades are counted from 1.
class FoamAlone : public tests::WaveSea {
  public:
    FoamAlone() { offered = sea::FieldSet{sea::Field::foam}; }
    void fetch(server::FetchRequest request, Fetched done) override {
        request.demand.fields = {}; // those of its waves
        WaveSea::fetch(std::move(request), [&](Result<server::FetchedPart> made) {
            for (server::KeyframeTiles& tiles : made->tiles) {
                auto own = std::make_shared<sea::Keyframe>(*tiles.keyframe);
                own->fields = {sea::Field::foam};
                own->values.assign(own->plane_size(), 1.0f + static_cast<float>(own->cascade));
                tiles = {own, {tests::wave_codec_m}, tiles.quality};
            }
            done(std::move(made));
        });
    }
};

/// And a client that is subscribed to it.
class Foam : public testing::Test {
  protected:
    FoamAlone sea;
    std::unique_ptr<server::NetServer> net = tests::serve(sea);
    Sea client{net->url()};
    sea::TimeUs now_us = 0; ///< what is held begins less than 0.1 s later

    void SetUp() override {
        seaway_wish alone = SEAWAY_SIZED(seaway_wish);
        alone.fields = SEAWAY_BIT(SEAWAY_FOAM);
        ASSERT_TRUE(eventually([&] {
            now_us = sea.sea_time_us();
            EXPECT_EQ(seaway_subscribe_to(client.handle(), &alone, nullptr), SEAWAY_OK)
                << seaway_last_error();
            return sea.sea_time_us() < now_us + 100'000;
        }));
    }
};

// Naive: maps are made of the surface, and where no heights were subscribed to there never is one.
TEST_F(Foam, that_was_subscribed_to_alone_has_its_maps) {
    seaway_map_wish wish = SEAWAY_SIZED(seaway_map_wish);
    seaway_map map = SEAWAY_SIZED(seaway_map);
    wish.cascade = 1;
    wish.time_us = now_us + 100'000;
    wish.channels = 2;
    wish.field[0] = SEAWAY_FOAM;
    wish.field[1] = SEAWAY_NO_FIELD;
    std::vector<float> texels(2 * tests::wave_map_size * tests::wave_map_size, 7.0f);
    const auto get = [&] {
        return seaway_get_map(client.handle(), &wish, texels.data(), texels.size() * sizeof(float),
                              &map);
    };
    ASSERT_EQ(get(), SEAWAY_OK) << seaway_last_error();
    EXPECT_EQ(map.grid, static_cast<std::uint32_t>(tests::wave_map_size));
    EXPECT_EQ(map.length_m, 29);
    EXPECT_EQ(map.error_m, 0);
    // Naive: heights that are not there are rounded as well.
    wish.type = SEAWAY_HALF;
    ASSERT_EQ(get(), SEAWAY_OK) << seaway_last_error();
    EXPECT_EQ(map.error_m, 0);
    EXPECT_EQ(map.displacement_error_m, 0);
    wish.type = SEAWAY_FLOAT;
    ASSERT_EQ(get(), SEAWAY_OK) << seaway_last_error();
    for (std::size_t i = 0; i < texels.size(); ++i)
        ASSERT_NEAR(texels[i], i % 2 == 0 ? 2.0f : 0.0f, tests::wave_codec_m) << i;
    wish.field[1] = SEAWAY_HEIGHT;
    EXPECT_EQ(get(), SEAWAY_NOT_HELD) << "of which nothing came";
}

// Naive: foam that is not of that time makes the whole answer one without keyframes, which a client that has lost its server
// refuses. Heights follow from waves at any time.
TEST_F(Foam, of_another_time_is_told_of_and_takes_nothing_from_the_heights) {
    seaway_subscription spectrum{};
    spectrum.rung = SEAWAY_SPECTRUM;
    client.subscribe(spectrum);
    const seaway_point point{1, 2, now_us + 60'000'000};
    seaway_water water{};
    const auto look = [&](const seaway_looking* looking) {
        EXPECT_EQ(seaway_sample_water(client.handle(), looking, &point, 1, &water, sizeof water),
                  SEAWAY_OK)
            << seaway_last_error();
        EXPECT_TRUE(std::isfinite(water.foam));
        return water.answer.flags;
    };
    seaway_looking flat = SEAWAY_SIZED(seaway_looking);
    flat.cascades = 2;
    flat.min_wavelength_m = 1e9; // than which all of its waves are shorter
    constexpr std::uint32_t late = SEAWAY_FOAM_LATE, stale = SEAWAY_STALE;
    EXPECT_EQ(look(nullptr), late);
    EXPECT_EQ(look(&flat), late);
    net->stop();
    ASSERT_TRUE(eventually([&] { return client.status().state != SEAWAY_CONNECTED; }));
    EXPECT_EQ(look(nullptr), late | stale);
    EXPECT_EQ(look(&flat), late | stale);
}

/// Half a minute of a minute's glide is over, from a tenth that is white to a fifth.
class FoamThatGrows : public FoamAlone {
  public:
    const sea::TimeUs begun_us = sea_time_us() - 30'000'000;
    std::vector<server::SharedBytes> sea_state_messages() const override {
        protocol::SeaStateValues state = protocol::values(
            *wire::GetMessage(WaveSea::sea_state_messages().back()->data())->body_as_SeaState());
        state.start_time_us = begun_us;
        state.foam_mean = 0.2;
        state.glide = protocol::GlideValues{.end_us = begun_us + 60'000'000, .foam_mean = 0.1};
        return {std::make_shared<const protocol::Bytes>(protocol::sea_state(state))};
    }
};

// docs/protocol.md, "Changes": x^3 (10 - 15 x + 6 x^2) of the way with x the share of the time.
TEST(FoamMaps, tell_the_mean_that_they_are_ratios_to_while_it_changes) {
    FoamThatGrows sea;
    const auto net = tests::serve(sea);
    Sea client(net->url());
    seaway_wish alone = SEAWAY_SIZED(seaway_wish);
    alone.fields = SEAWAY_BIT(SEAWAY_FOAM);
    seaway_map_wish wish = SEAWAY_SIZED(seaway_map_wish);
    wish.channels = 1;
    wish.field[0] = SEAWAY_FOAM;
    seaway_map map = SEAWAY_SIZED(seaway_map);
    // Some tenths of a second are held, which a busy machine may have slept through.
    seaway_code code = SEAWAY_NOT_HELD;
    for (int i = 0; i < 5 && code == SEAWAY_NOT_HELD; ++i) {
        ASSERT_EQ(seaway_subscribe_to(client.handle(), &alone, nullptr), SEAWAY_OK)
            << seaway_last_error();
        wish.time_us = client.now_us();
        code = seaway_get_map(client.handle(), &wish, nullptr, 0, &map);
    }
    ASSERT_EQ(code, SEAWAY_OK) << seaway_last_error();
    const double x = static_cast<double>(wish.time_us - sea.begun_us) / 60e6;
    EXPECT_NEAR(map.foam_mean, 0.1 + 0.1 * x * x * x * (10 - 15 * x + 6 * x * x), 1e-12);
    // A program of the header before has no room for it, and nothing is written there.
    map.size = offsetof(seaway_map, foam_mean);
    map.foam_mean = 77;
    ASSERT_EQ(seaway_get_map(client.handle(), &wish, nullptr, 0, &map), SEAWAY_OK);
    EXPECT_EQ(map.foam_mean, 77);
}

TEST_F(Engine, says_what_a_time_would_be_answered_from_and_why) {
    Sea client(net->url());
    seaway_source source = SEAWAY_SIZED(seaway_source);
    const auto from = [&] {
        EXPECT_EQ(seaway_get_source(client.handle(), asked_us, &source), SEAWAY_OK);
        return source.source;
    };
    EXPECT_EQ(from(), static_cast<std::uint32_t>(SEAWAY_FROM_SERVER));
    EXPECT_NE(std::string(source.why).find("no keyframe"), std::string::npos);
    client.hold({asked_us});
    EXPECT_EQ(from(), static_cast<std::uint32_t>(SEAWAY_FROM_TILES));
    seaway_subscription spectrum{};
    spectrum.rung = SEAWAY_SPECTRUM;
    client.subscribe(spectrum);
    EXPECT_EQ(from(), static_cast<std::uint32_t>(SEAWAY_FROM_SPECTRUM));
    EXPECT_NE(refusal(seaway_rebuild(client.handle(), asked_us), SEAWAY_NOT_HELD).find("no scene"),
              std::string::npos);
    EXPECT_EQ(from(), static_cast<std::uint32_t>(SEAWAY_FROM_SPECTRUM));
    for (const std::int64_t never_us : {INT64_MIN, INT64_MAX, sea::time_us_max + 1})
        EXPECT_EQ(seaway_get_source(client.handle(), never_us, &source), SEAWAY_BAD_ARGUMENT);
}

TEST_F(Engine, the_worked_examples_of_the_header_work_in_c) {
    Sea client(net->url());
    client.subscribe();
    std::vector<float> texels(4 * 32 * 32);
    seaway_map map = SEAWAY_SIZED(seaway_map);
    // Some tenths of a second are held: a machine that stands still for longer may be behind them, so of a few times once is enough.
    seaway_code code = SEAWAY_NOT_HELD;
    for (int i = 0; i < 5 && code == SEAWAY_NOT_HELD; ++i)
        code = one_map_in_c(client.handle(), texels.data(), texels.size() * sizeof(float), &map);
    ASSERT_EQ(code, SEAWAY_OK) << seaway_last_error();
    EXPECT_EQ(map.length_m, 160);
    seaway_answer water{};
    ASSERT_EQ(one_question_in_c(client.handle(), &water), SEAWAY_OK) << seaway_last_error();
    EXPECT_GT(water.error_m, 0);
}

} // namespace
} // namespace seaway
