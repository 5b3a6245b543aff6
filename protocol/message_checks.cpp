// SPDX-License-Identifier: Apache-2.0
// Ranges of the values in a verified message (protocol/messages.h). Only the shape of a message is
// proven by the verifier; a cascade number, a size or a count can still be anything.
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "protocol/value_checks.h"
#include "sea/basics/pace.h"

namespace seaway::protocol {
namespace {

/// One of a list, within `max` either side of 0. What is not a finite number is let through: such a
/// point is answered, and flagged, like the others.
template <class T>
Result<void> within(std::string_view field, std::size_t index, T value, T max) {
    if ((value >= -max && value <= max) || !std::isfinite(value))
        return {};
    return Error{wire::ErrorCode::bad_value, fmt::format("{} [{}] is {}, allowed are {} to {}",
                                                         field, index, value, -max, max)};
}

Result<void> check_fields(std::uint32_t bits) {
    if (bits != 0)
        return {};
    return Error{wire::ErrorCode::bad_value, "fields is empty: nothing is asked for"};
}

} // namespace

Result<void> check(const wire::Message& message) {
    using wire::Body;
    switch (message.body_type()) { // no default: a new kind must be thought of
    case Body::Hello:
        return check(*message.body_as_Hello());
    case Body::Subscribe:
        return check(*message.body_as_Subscribe());
    case Body::Ack:
        return check(*message.body_as_Ack());
    case Body::Fetch:
        return check(*message.body_as_Fetch());
    case Body::Query:
        return check(*message.body_as_Query());
    case Body::Welcome:
        return check(*message.body_as_Welcome());
    case Body::SeaState:
        return check(*message.body_as_SeaState());
    case Body::Subscribed:
        return check(*message.body_as_Subscribed());
    case Body::Tile:
        return check(*message.body_as_Tile());
    case Body::QueryReply:
        return check(*message.body_as_QueryReply());
    case Body::SubscribeSpectrum:
        return check(*message.body_as_SubscribeSpectrum());
    case Body::SpectrumSubscribed:
        return check(*message.body_as_SpectrumSubscribed());
    case Body::Spectrum:
        return check(*message.body_as_Spectrum());
    case Body::SpectrumChunk:
        return check(*message.body_as_SpectrumChunk());
    case Body::Change:
        return check(*message.body_as_Change());
    case Body::Administer:
        return check(*message.body_as_Administer());
    case Body::Changed:
        return check(*message.body_as_Changed());
    case Body::Pace:
        return check(*message.body_as_Pace());
    case Body::GoAway:
        return check(*message.body_as_GoAway());
    case Body::Pong:
        return check(*message.body_as_Pong());
    case Body::NONE:
    case Body::Unsubscribe:
    case Body::Ping:
    case Body::FetchDone:
    case Body::Refused:
    case Body::Administered:
        break;
    }
    return {};
}

Result<void> check(const wire::Hello& hello) {
    return all_of(in_range<std::size_t>("count of versions", count(hello.versions()), 1,
                                        limits::versions_per_hello_max),
                  text_fits("client", hello.client(), limits::hello_text_bytes_max),
                  text_fits("token", hello.token(), limits::hello_text_bytes_max));
}

Result<void> check(const wire::Subscribe& subscribe) {
    return all_of(
        check_fields(subscribe.fields()),
        in_range("error_m", subscribe.error_m(), 0.0f, limits::error_m_max),
        in_range<int>("credit", subscribe.credit(), limits::credit_min, limits::credit_max),
        subscribe.rate_hz_max() == 0 ? Result<void>()
                                     : in_range("rate_hz_max", subscribe.rate_hz_max(),
                                                limits::rate_hz_min, limits::rate_hz_max),
        subscribe.size_max() == 0 ? Result<void>()
                                  : in_range<int>("size_max", subscribe.size_max(),
                                                  limits::size_min, limits::map_side_max));
}

Result<void> check(const wire::Ack& ack) {
    return in_range<std::size_t>("count of also", count(ack.also()), 0,
                                 limits::keyframes_per_ack_max - 1);
}

Result<void> check(const wire::Fetch& fetch) {
    SEAWAY_TRY(all_of(check_fields(fetch.fields()),
                      in_range("error_m", fetch.error_m(), 0.0f, limits::error_m_max),
                      in_range<std::size_t>("count of times_us", count(fetch.times_us()), 1,
                                            limits::times_per_fetch_max)));
    for (flatbuffers::uoffset_t i = 0; i < fetch.times_us()->size(); ++i)
        SEAWAY_TRY(within("times_us", i, fetch.times_us()->Get(i), limits::time_us_max));
    return {};
}

Result<void> check(const wire::Query& query) {
    const bool exact = query.exact() || count(query.z_m()) != 0;
    const std::size_t points_max =
        exact ? limits::exact_points_per_query_max : limits::points_per_query_max;
    if (count(query.points()) > points_max)
        return Error{wire::ErrorCode::too_many_points,
                     fmt::format("count of points is {}, allowed are 0 to {}",
                                 count(query.points()), points_max)};
    for (flatbuffers::uoffset_t i = 0; i < count(query.points()); ++i) {
        const wire::Point& point = *query.points()->Get(i);
        SEAWAY_TRY(within("points.time_us", i, point.time_us(), limits::time_us_max));
        SEAWAY_TRY(within("points.x_m", i, point.x_m(), limits::position_m_max));
        SEAWAY_TRY(within("points.y_m", i, point.y_m(), limits::position_m_max));
    }
    const std::size_t depths = count(query.z_m());
    if (depths != 0 && depths != count(query.points()))
        return Error{wire::ErrorCode::bad_value,
                     fmt::format("count of z_m is {}, allowed are 0 and that of points, {}", depths,
                                 count(query.points()))};
    for (flatbuffers::uoffset_t i = 0; i < depths; ++i)
        SEAWAY_TRY(within("z_m", i, query.z_m()->Get(i), limits::position_m_max));
    return in_range("min_wavelength_m", query.min_wavelength_m(), 0.0, limits::position_m_max);
}

Result<void> check(const wire::Change& change) {
    const std::size_t values = count(change.set());
    if (const flatbuffers::Optional<std::uint32_t> pace = change.pace_permille()) {
        if (values != 0 || count(change.scene()) != 0)
            return Error{wire::ErrorCode::bad_value,
                         "a change of pace has no `set` and no `scene`"};
        return in_range<std::uint32_t>("pace_permille", *pace, 0, sea::pace_permille_max);
    }
    if ((values == 0) == (count(change.scene()) == 0))
        return Error{wire::ErrorCode::bad_value,
                     "a change has either values in `set` or a `scene`, one of them"};
    SEAWAY_TRY(
        all_of(in_range<std::size_t>("count of set", values, 0, limits::values_per_change_max),
               text_fits("scene", change.scene(), limits::change_scene_bytes_max),
               in_range("over_us", change.over_us(), sea::glide_us_min, sea::glide_us_max),
               in_range("at_us", change.at_us(), -limits::time_us_max, limits::time_us_max)));
    for (flatbuffers::uoffset_t i = 0; i < values; ++i)
        SEAWAY_TRY(text_fits("set", change.set()->Get(i), limits::change_value_bytes_max));
    return {};
}

Result<void> check(const wire::Administer& administer) {
    return in_range("act", static_cast<int>(administer.act()), static_cast<int>(wire::Act::MIN),
                    static_cast<int>(wire::Act::MAX));
}

Result<void> check(const wire::Changed& changed) {
    return all_of(
        in_range("start_us", changed.start_us(), -limits::time_us_max, limits::time_us_max),
        in_range("end_us", changed.end_us(), changed.start_us(), limits::time_us_max));
}

Result<void> check(const wire::Pace& pace) {
    return all_of(
        in_range("from_us", pace.from_us(), -limits::time_us_max, limits::time_us_max),
        in_range("sea_time_us", pace.sea_time_us(), -limits::time_us_max, limits::time_us_max),
        in_range<std::uint32_t>("permille", pace.permille(), 0, sea::pace_permille_max));
}

Result<void> check(const wire::GoAway& go_away) {
    return in_range<std::uint32_t>("retry_after_ms", go_away.retry_after_ms(), 0,
                                   limits::retry_after_ms_max);
}

namespace {

/// Of a Welcome or a Pong: clocks add such times to each other.
template <class Told>
Result<void> check_times(const Told& told) {
    return all_of(
        in_range("sea_time_us", told.sea_time_us(), -limits::time_us_max, limits::time_us_max),
        in_range("elapsed_us", told.elapsed_us().value_or(0), -limits::time_us_max,
                 limits::time_us_max));
}

} // namespace

Result<void> check(const wire::Welcome& welcome) {
    return all_of(in_range<int>("version", welcome.version(), version, version),
                  check_times(welcome));
}

Result<void> check(const wire::Pong& pong) {
    return check_times(pong);
}

Result<void> check(const wire::Subscribed& subscribed) {
    const wire::TileLimits* const limited = subscribed.limits();
    return all_of(
        in_range("limits.rate_hz", limited ? limited->rate_hz() : 0.0f, 0.0f, 1e6f),
        in_range<std::uint32_t>("limits.size", limited ? limited->size() : 0, 0,
                                limits::map_side_max),
        in_range("error_m", subscribed.error_m(), 0.0f, limits::error_m_max),
        in_range<int>("credit", subscribed.credit(), limits::credit_min, limits::credit_max));
}

namespace {

/// None, or what a loss can be.
Result<void> check_coarser(const wire::Coarser* coarser) {
    if (coarser == nullptr)
        return {};
    return all_of(
        in_range<std::int64_t>("coarser.interval_us", coarser->interval_us(), 1, interval_us_max),
        in_range("coarser.time_m", coarser->time_m(), 0.0f, 1e9f),
        in_range("coarser.displacement_time_m", coarser->displacement_time_m(), 0.0f, 1e9f),
        in_range("coarser.cut_m", coarser->cut_m(), 0.0f, 1e9f),
        in_range("coarser.displacement_cut_m", coarser->displacement_cut_m(), 0.0f, 1e9f),
        in_range("coarser.strain", coarser->strain(), 0.0f, 1e9f));
}

Result<void> check_noise(const wire::Noise* noise) {
    if (noise == nullptr)
        return {};
    return all_of(
        in_range("noise.before_us", noise->before_us(), -limits::time_us_max, limits::time_us_max),
        in_range("noise.at_m", noise->at_m(), 0.0f, 1e6f),
        in_range("noise.between_m", noise->between_m(), 0.0f, 1e6f));
}

} // namespace

Result<void> check(const wire::Tile& tile) {
    SEAWAY_TRY(check_coarser(tile.coarser()));
    SEAWAY_TRY(check_noise(tile.noise()));
    const int size = tile.size();
    return all_of(in_range<int>("cascade", tile.cascade(), 0, limits::cascades_max - 1),
                  in_range<int>("field", static_cast<int>(tile.field()), 0, sea::field_count - 1),
                  in_range<int>("size", size, 1, limits::map_side_max),
                  in_range<int>("width", tile.width(), 1, limits::tile_side_max),
                  in_range<int>("height", tile.height(), 1, limits::tile_side_max),
                  in_range<int>("x0", tile.x0(), 0, size - tile.width()),
                  in_range<int>("y0", tile.y0(), 0, size - tile.height()),
                  in_range<int>("parts", tile.parts(), 1, limits::parts_max),
                  in_range<int>("part", tile.part(), 0, tile.parts() - 1),
                  in_range("error", tile.error(), 0.0f, 1e6f),
                  in_range<std::size_t>("count of payload bytes", count(tile.payload()), 1,
                                        limits::server_message_bytes_max));
}

Result<void> check(const wire::QueryReply& reply) {
    if (count(reply.below()) != 0 && count(reply.below()) != count(reply.answers()))
        return Error{wire::ErrorCode::bad_value,
                     fmt::format("count of below is {}, allowed are 0 and that of answers, {}",
                                 count(reply.below()), count(reply.answers()))};
    return in_range<std::size_t>("count of answers", count(reply.answers()), 0,
                                 limits::points_per_query_max);
}

Result<void> check(const wire::SubscribeSpectrum& subscribe) {
    return all_of(in_range("error_m", subscribe.error_m(), 0.0f, limits::error_m_max),
                  in_range("slope_error", subscribe.slope_error(), 0.0f, limits::slope_error_max));
}

Result<void> check(const wire::SpectrumSubscribed& subscribed) {
    return all_of(in_range("error_m", subscribed.error_m(), 0.0f, limits::error_m_max),
                  in_range("slope_error", subscribed.slope_error(), 0.0f, limits::error_m_max),
                  in_range<std::uint32_t>("spectra", subscribed.spectra(), 0, limits::spectra_max));
}

Result<void> check(const wire::Spectrum& spectrum) {
    return all_of(
        in_range<std::uint32_t>("chunks", spectrum.chunks(), 0, limits::spectrum_chunks_max),
        in_range<std::uint32_t>("bytes", spectrum.bytes(), 0, limits::spectrum_bytes_max),
        in_range("step_m", spectrum.step_m(), 0.0, 1e6),
        in_range("step_length_m", spectrum.step_length_m(), 0.0, 1e9), check_law("", spectrum));
}

Result<void> check(const wire::SpectrumChunk& chunk) {
    return all_of(
        in_range<std::uint32_t>("chunk", chunk.chunk(), 0, limits::spectrum_chunks_max - 1),
        in_range("left_m", chunk.left_m(), 0.0f, limits::spectrum_left_m_max),
        in_range("left_displacement_m", chunk.left_displacement_m(), 0.0f,
                 limits::spectrum_left_displacement_m_max),
        in_range("left_slope", chunk.left_slope(), 0.0f, limits::spectrum_left_slope_max),
        in_range<std::size_t>("count of payload bytes", count(chunk.payload()), 1,
                              limits::spectrum_chunk_bytes_max));
}

} // namespace seaway::protocol
