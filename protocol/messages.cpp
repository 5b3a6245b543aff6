// SPDX-License-Identifier: Apache-2.0
#include "protocol/messages.h"

#include <cstring>

#include <fmt/format.h>

#include "base/bound_to_float.h"
#include "protocol/limits.h"
#include "protocol/list_alignment.h"

namespace seaway::protocol {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

/// force_defaults: every scalar has its place in the message: equal shapes are equal layouts.
FlatBufferBuilder builder(std::size_t bytes_expected) {
    FlatBufferBuilder built(bytes_expected);
    built.ForceDefaults(true);
    return built;
}

template <class T>
Bytes finish(FlatBufferBuilder& built, Offset<T> body) {
    const auto message = wire::CreateMessage(built, wire::BodyTraits<T>::enum_value, body.Union());
    built.Finish(message, wire::MessageIdentifier());
    return {built.GetBufferPointer(), built.GetBufferPointer() + built.GetSize()};
}

template <class T>
Offset<flatbuffers::Vector<T>> vector_of(FlatBufferBuilder& built, std::span<const T> values) {
    return built.CreateVector(values.data(), values.size());
}

Offset<flatbuffers::String> string_of(FlatBufferBuilder& built, std::string_view text) {
    return built.CreateString(text.data(), text.size());
}

} // namespace

Result<const wire::Message*> MessageReader::read(std::span<const std::uint8_t> bytes) {
    const std::size_t bytes_max = sender_ == Sender::client ? limits::client_message_bytes_max
                                                            : limits::server_message_bytes_max;
    // 8: root offset and identifier, which the verifier reads without asking for the latter.
    if (bytes.size() < 8 || bytes.size() > bytes_max)
        return Error{
            fmt::format("message of {} bytes, 8 to {} are allowed", bytes.size(), bytes_max)};
    if (reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(std::uint64_t) != 0) {
        aligned_.resize((bytes.size() + 7) / 8);
        std::memcpy(aligned_.data(), bytes.data(), bytes.size());
        bytes = {reinterpret_cast<const std::uint8_t*>(aligned_.data()), bytes.size()};
    }
    flatbuffers::Verifier verifier(bytes.data(), bytes.size(), limits::verifier_depth_max,
                                   limits::verifier_tables_max);
    if (!wire::VerifyMessageBuffer(verifier) || !lists_aligned(*wire::GetMessage(bytes.data())))
        return Error{fmt::format("{} bytes that are not a seaway message", bytes.size())};
    const wire::Message* message = wire::GetMessage(bytes.data());
    const wire::Body kind = message->body_type();
    if (kind == wire::Body::NONE)
        return Error{"message without a body"};
    const MessageInfo* known = find_message(kind);
    if (known ? known->sender != sender_ : sender_ == Sender::client)
        return Error{fmt::format("message kind {} does not come from a {}", static_cast<int>(kind),
                                 sender_ == Sender::client ? "client" : "server")};
    return message;
}

// ---- client to server ----------------------------------------------------------------------

Bytes hello(std::string_view client, std::string_view token,
            std::span<const std::uint16_t> versions) {
    FlatBufferBuilder built = builder(256);
    const auto list = vector_of(built, versions);
    const auto name = string_of(built, client);
    const auto secret = string_of(built, token);
    return finish(built, wire::CreateHello(built, list, name, secret));
}

Bytes subscribe(std::uint32_t request_id, const TileWish& wish, int credit) {
    FlatBufferBuilder built = builder(128);
    return finish(built, wire::CreateSubscribe(
                             built, request_id, wish.cascades, wish.fields.bits(), wish.error_m,
                             static_cast<std::uint8_t>(credit), wish.compact, wish.rate_hz_max,
                             static_cast<std::uint16_t>(wish.size_max), wish.predicted));
}

Bytes unsubscribe(bool spectrum) {
    FlatBufferBuilder built = builder(64);
    return finish(built, wire::CreateUnsubscribe(built, spectrum));
}

Bytes subscribe_spectrum(std::uint32_t request_id, const SpectrumWish& wish) {
    FlatBufferBuilder built = builder(128);
    return finish(built, wire::CreateSubscribeSpectrum(built, request_id, wish.error_m,
                                                       wish.slope_error, wish.fields.bits()));
}

Bytes ack(std::uint64_t keyframe, std::span<const std::uint64_t> also) {
    FlatBufferBuilder built = builder(128);
    const auto others =
        also.empty() ? Offset<flatbuffers::Vector<std::uint64_t>>() : vector_of(built, also);
    return finish(built, wire::CreateAck(built, keyframe, others));
}

Bytes fetch(std::uint32_t request_id, std::span<const sea::TimeUs> times_us, const TileWish& wish) {
    FlatBufferBuilder built = builder(256);
    const auto times = vector_of(built, times_us);
    return finish(built, wire::CreateFetch(built, request_id, times, wish.cascades,
                                           wish.fields.bits(), wish.error_m, wish.compact));
}

Bytes query(std::uint32_t request_id, std::span<const sea::QueryPoint> points, bool exact,
            const sea::Looking& looking, std::span<const double> z_m) {
    FlatBufferBuilder built = builder(192 + points.size() * sizeof(wire::Point) + z_m.size_bytes());
    const auto depths = vector_of(built, z_m);
    wire::Point* list = nullptr;
    const auto offset = built.CreateUninitializedVectorOfStructs(points.size(), &list);
    for (std::size_t i = 0; i < points.size(); ++i)
        list[i] = wire::Point(points[i].x_m, points[i].y_m, points[i].time_us);
    return finish(built, wire::CreateQuery(built, request_id, exact, offset, looking.cascades,
                                           looking.min_wavelength_m, depths));
}

sea::Looking looking(const wire::Query& query) {
    return {query.cascades(), query.min_wavelength_m()};
}

Bytes ping(std::uint32_t request_id, std::int64_t client_time_us) {
    FlatBufferBuilder built = builder(64);
    return finish(built, wire::CreatePing(built, request_id, client_time_us));
}

Bytes change(std::uint32_t request_id, const ChangeWish& wish) {
    FlatBufferBuilder built = builder(256 + wish.scene.size());
    const auto set = built.CreateVectorOfStrings(wish.set);
    const auto scene = string_of(built, wish.scene);
    return finish(built,
                  wire::CreateChange(built, request_id, set, scene, wish.over_us, wish.at_us,
                                     wish.pace_permille
                                         ? flatbuffers::Optional<std::uint32_t>(
                                               static_cast<std::uint32_t>(*wish.pace_permille))
                                         : flatbuffers::nullopt));
}

Bytes administer(std::uint32_t request_id, wire::Act act, std::uint64_t session) {
    FlatBufferBuilder built = builder(64);
    return finish(built, wire::CreateAdminister(built, request_id, act, session));
}

// ---- server to client ----------------------------------------------------------------------

namespace {

/// Nothing where it is sea time.
flatbuffers::Optional<std::int64_t> elapsed_us(const sea::SeaTime& time) {
    if (time.elapsed_us == time.sea_us)
        return flatbuffers::nullopt;
    return time.elapsed_us;
}

} // namespace

Bytes welcome(std::uint64_t session, std::string_view server, const sea::SeaTime& time) {
    FlatBufferBuilder built = builder(256);
    const auto name = string_of(built, server);
    return finish(built, wire::CreateWelcome(
                             built, version, session, name, time.sea_us,
                             limits::points_per_query_max, limits::exact_points_per_query_max,
                             limits::times_per_fetch_max, limits::client_message_bytes_max,
                             elapsed_us(time), limits::keyframes_per_ack_max, time.unsure_us));
}

Bytes subscribed(std::uint32_t request_id, const TileWish& grant, int credit,
                 std::string_view why) {
    FlatBufferBuilder built = builder(256);
    // Absent where there is nothing to say: who asks for nothing new reads the bytes of old.
    const auto reason = why.empty() ? Offset<flatbuffers::String>() : string_of(built, why);
    const wire::TileLimits limits(grant.rate_hz_max, static_cast<std::uint32_t>(grant.size_max));
    const bool limited = grant.rate_hz_max > 0 || grant.size_max > 0;
    return finish(built,
                  wire::CreateSubscribed(built, request_id, grant.cascades, grant.fields.bits(),
                                         grant.error_m, static_cast<std::uint8_t>(credit), reason,
                                         limited ? &limits : nullptr));
}

namespace {

wire::Coarser wire_of(const sea::CoarserLoss& loss) {
    return {loss.interval_us,
            bound_to_float(loss.time_m),
            bound_to_float(loss.displacement_time_m),
            bound_to_float(loss.cut_m),
            bound_to_float(loss.displacement_cut_m),
            bound_to_float(loss.strain),
            0};
}

sea::CoarserLoss loss_of(const wire::Coarser* loss) {
    if (loss == nullptr)
        return {};
    return {loss->interval_us(),
            static_cast<double>(loss->time_m()),
            static_cast<double>(loss->displacement_time_m()),
            static_cast<double>(loss->cut_m()),
            static_cast<double>(loss->displacement_cut_m()),
            static_cast<double>(loss->strain())};
}

sea::CodedNoise noise_of(const wire::Noise* n, std::uint64_t number) {
    return n ? sea::CodedNoise{number, n->before(), n->before_us(), n->at_m(), n->between_m()}
             : sea::CodedNoise{};
}

} // namespace

Bytes tile(const TileHeader& header, std::span<const std::uint8_t> payload) {
    FlatBufferBuilder built = builder(192 + payload.size());
    const wire::Coarser coarser = wire_of(header.coarser);
    const wire::Noise noise(header.noise.before, header.noise.before_us,
                            bound_to_float(header.noise.at_m),
                            bound_to_float(header.noise.between_m));
    const auto made = wire::CreateTile(
        built, header.keyframe, header.epoch, static_cast<std::uint8_t>(header.cascade),
        static_cast<wire::Field>(header.field), header.time_us,
        static_cast<std::uint16_t>(header.size), static_cast<std::uint16_t>(header.x0),
        static_cast<std::uint16_t>(header.y0), static_cast<std::uint16_t>(header.width),
        static_cast<std::uint16_t>(header.height), static_cast<std::uint16_t>(header.part),
        static_cast<std::uint16_t>(header.parts), header.error, vector_of(built, payload),
        header.follows.bits(), header.coarser.interval_us != 0 ? &coarser : nullptr,
        header.base != 0 ? std::optional(header.base) : std::nullopt,
        header.noise.at_m > 0 ? &noise : nullptr);
    return finish(built, made);
}

TileHeader header(const wire::Tile& tile) {
    return {.keyframe = tile.keyframe(),
            .epoch = tile.epoch(),
            .cascade = tile.cascade(),
            .field = static_cast<sea::Field>(tile.field()),
            .time_us = tile.time_us(),
            .size = tile.size(),
            .x0 = tile.x0(),
            .y0 = tile.y0(),
            .width = tile.width(),
            .height = tile.height(),
            .part = tile.part(),
            .parts = tile.parts(),
            .error = tile.error(),
            .follows = sea::FieldSet::from_bits(tile.follows()),
            .coarser = loss_of(tile.coarser()),
            .base = tile.base().value_or(0),
            .noise = noise_of(tile.noise(), tile.keyframe())};
}

Bytes query_reply(std::uint32_t request_id, std::uint32_t epoch,
                  std::span<const sea::Answer> answers, std::span<const sea::WaterBelow> below,
                  std::optional<std::uint32_t> cascades) {
    FlatBufferBuilder built = builder(192 + answers.size() * sizeof(wire::PointAnswer) +
                                      below.size() * sizeof(wire::Below));
    wire::Below* waters = nullptr;
    const auto below_offset = built.CreateUninitializedVectorOfStructs(below.size(), &waters);
    for (std::size_t i = 0; i < below.size(); ++i)
        waters[i] = wire::Below(static_cast<float>(below[i].velocity_mps[0]),
                                static_cast<float>(below[i].velocity_mps[1]),
                                static_cast<float>(below[i].velocity_mps[2]),
                                static_cast<float>(below[i].pressure_m2ps2));
    wire::PointAnswer* list = nullptr;
    const auto offset = built.CreateUninitializedVectorOfStructs(answers.size(), &list);
    for (const sea::Answer& a : answers)
        *list++ = wire::PointAnswer(
            a.height_m, static_cast<float>(a.normal[0]), static_cast<float>(a.normal[1]),
            static_cast<float>(a.normal[2]), static_cast<float>(a.velocity_mps[0]),
            static_cast<float>(a.velocity_mps[1]), static_cast<float>(a.velocity_mps[2]),
            bound_to_float(a.error_m), a.flags);
    return finish(built,
                  wire::CreateQueryReply(built, request_id, epoch, offset, below_offset, cascades));
}

sea::WaterBelow water(const wire::Below& below) {
    return {
        .velocity_mps = {below.velocity_x_mps(), below.velocity_y_mps(), below.velocity_z_mps()},
        .pressure_m2ps2 = below.pressure_m2ps2()};
}

sea::Answer answer(const wire::PointAnswer& a) {
    return {.height_m = a.height_m(),
            .normal = {a.normal_x(), a.normal_y(), a.normal_z()},
            .velocity_mps = {a.velocity_x_mps(), a.velocity_y_mps(), a.velocity_z_mps()},
            .error_m = a.error_m(),
            .flags = a.flags()};
}

Bytes fetch_done(std::uint32_t request_id, std::uint32_t keyframes, sea::FieldSet fields) {
    FlatBufferBuilder built = builder(64);
    return finish(built, wire::CreateFetchDone(built, request_id, keyframes, fields.bits()));
}

Bytes pong(std::uint32_t request_id, std::int64_t client_time_us, const sea::SeaTime& time) {
    FlatBufferBuilder built = builder(96);
    return finish(built, wire::CreatePong(built, request_id, client_time_us, time.sea_us,
                                          elapsed_us(time), time.unsure_us));
}

Bytes pace(const sea::Pace& pace) {
    FlatBufferBuilder built = builder(64);
    return finish(built, wire::CreatePace(built, pace.from_us, pace.sea_us,
                                          static_cast<std::uint32_t>(pace.permille)));
}

sea::Pace pace(const wire::Pace& pace) {
    return {pace.from_us(), pace.sea_time_us(), static_cast<int>(pace.permille())};
}

Bytes spectrum_subscribed(std::uint32_t request_id, const SpectrumGrant& grant) {
    FlatBufferBuilder built = builder(256);
    const auto why = string_of(built, grant.why);
    return finish(built, wire::CreateSpectrumSubscribed(built, request_id, grant.error_m,
                                                        grant.slope_error, grant.fields.bits(),
                                                        grant.spectra, why));
}

SpectrumGrant grant(const wire::SpectrumSubscribed& subscribed) {
    return {.error_m = subscribed.error_m(),
            .slope_error = subscribed.slope_error(),
            .fields = sea::FieldSet::from_bits(subscribed.fields()),
            .spectra = subscribed.spectra(),
            .why = subscribed.why() ? subscribed.why()->str() : std::string()};
}

Bytes spectrum(const SpectrumHead& head) {
    FlatBufferBuilder built = builder(256);
    return finish(built, wire::CreateSpectrum(built, head.epoch, head.chunks, head.bytes,
                                              head.steps.step_m, head.steps.length_m,
                                              head.dispersion.gravity_mps2,
                                              head.dispersion.surface_tension_m3ps2,
                                              head.dispersion.depth_m, head.loop_period_us));
}

SpectrumHead head(const wire::Spectrum& spectrum) {
    return {.epoch = spectrum.epoch(),
            .chunks = spectrum.chunks(),
            .bytes = spectrum.bytes(),
            .steps = {spectrum.step_m(), spectrum.step_length_m()},
            .dispersion = {spectrum.gravity_mps2(), spectrum.surface_tension_m3ps2(),
                           spectrum.depth_m()},
            .loop_period_us = spectrum.loop_period_us()};
}

Bytes spectrum_chunk(std::uint32_t epoch, std::uint32_t chunk, const sea::SpectrumLeft& left,
                     std::span<const std::uint8_t> payload) {
    FlatBufferBuilder built = builder(128 + payload.size());
    const auto bytes = vector_of(built, payload);
    return finish(built,
                  wire::CreateSpectrumChunk(built, epoch, chunk, bound_to_float(left.height_m),
                                            bound_to_float(left.displacement_m),
                                            bound_to_float(left.slope), bytes));
}

sea::SpectrumLeft left(const wire::SpectrumChunk& chunk) {
    return {static_cast<double>(chunk.left_m()), static_cast<double>(chunk.left_displacement_m()),
            static_cast<double>(chunk.left_slope())};
}

Bytes changed(std::uint32_t request_id, std::uint32_t epoch, sea::TimeUs start_us,
              sea::TimeUs end_us, std::uint32_t change) {
    FlatBufferBuilder built = builder(64);
    return finish(built, wire::CreateChanged(built, request_id, epoch, start_us, end_us, change));
}

Bytes administered(std::uint32_t request_id, std::string_view text) {
    FlatBufferBuilder built = builder(128 + text.size());
    const auto said = string_of(built, text);
    return finish(built, wire::CreateAdministered(built, request_id, said));
}

Bytes refused(std::uint32_t request_id, wire::ErrorCode code, std::string_view message,
              std::uint32_t retry_after_ms) {
    FlatBufferBuilder built = builder(256);
    const auto text = string_of(built, message);
    return finish(built, wire::CreateRefused(built, request_id, code, text, retry_after_ms));
}

Bytes go_away(wire::ErrorCode code, std::string_view message, std::uint32_t retry_after_ms) {
    FlatBufferBuilder built = builder(256);
    const auto text = string_of(built, message);
    return finish(built, wire::CreateGoAway(built, code, text, retry_after_ms));
}

std::string_view name(wire::ErrorCode code) {
    const std::string_view known = wire::EnumNameErrorCode(code);
    return known.empty() ? "unknown" : known;
}

std::uint16_t close_code(wire::ErrorCode code) {
    return code == wire::ErrorCode::none
               ? std::uint16_t{1000}
               : static_cast<std::uint16_t>(4000 + static_cast<unsigned>(code));
}

} // namespace seaway::protocol
