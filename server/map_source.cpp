// SPDX-License-Identifier: Apache-2.0
#include "server/map_source.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "base/stand_back.h"
#include "protocol/map_header.h"

namespace seaway::server {

namespace {

/// A sea::MapStream as bytes: its header, then rows of float32.
class MapBytes final : public ByteSource {
  public:
    MapBytes(const sea::MapRequest& request, const sea::Surface& surface,
             std::unique_ptr<sea::MapStream> stream, Room::Place place)
        : place_(std::move(place)),
          header_(protocol::map_header(request, map_height_error_m(surface))),
          size_(bytes_of_map(request)), stream_(std::move(stream)) {}

    std::uint64_t size() const override { return size_; }
    bool failed() const override { return stream_->failed(); }

    std::vector<std::uint8_t> next() override {
        if (!header_sent_) {
            std::vector<std::uint8_t> bytes(header_.begin(), header_.end());
            header_sent_ = true;
            return bytes;
        }
        if (!chunk_ && stream_->ready())
            chunk_ = stream_->next_chunk();
        if (!chunk_)
            return {};
        std::vector<std::uint8_t> bytes(chunk_->values.size() * sizeof(float));
        std::memcpy(bytes.data(), chunk_->values.data(), bytes.size());
        chunk_.reset();
        return bytes;
    }

  private:
    Room::Place place_; ///< given back last
    std::array<std::uint8_t, protocol::map_header_bytes> header_;
    std::uint64_t size_;
    bool header_sent_ = false;
    std::unique_ptr<sea::MapStream> stream_;
    std::optional<sea::MapChunk> chunk_; ///< the next one, until there is memory for its bytes
};

Error bad_value(std::string why) {
    return {Refusal::bad_value, std::move(why)};
}

/// The whole text as a number, or an error that names the parameter.
template <class T>
Result<void> read_number(const std::string& name, const std::string& text, T& to) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
    if (end != text.data() + text.size() || error == std::errc::invalid_argument)
        return bad_value(fmt::format("{} = \"{}\" is not a {}", name, text,
                                     std::is_integral_v<T> ? "whole number" : "number"));
    using Limits = std::numeric_limits<T>;
    if (error != std::errc()) // no T holds it: the nearest does, and is held to the field's range
        to = static_cast<T>(std::clamp<double>(std::strtod(text.c_str(), nullptr), Limits::lowest(),
                                               Limits::max()));
    return {};
}

Result<void> read_time(const std::string& name, const std::string& text, sea::TimeUs& to) {
    double t_s = 0;
    SEAWAY_TRY(read_number(name, text, t_s));
    if (!(std::abs(t_s) <= sea::time_max_s)) // false for NaN
        return bad_value(fmt::format("{} = {} is out of range, {} .. {}", name, text,
                                     -sea::time_max_s, sea::time_max_s));
    to = sea::us_from_seconds(t_s);
    return {};
}

Result<void> read_kind(const std::string& text, sea::MapKind& to) {
    const Result<sea::MapKind> kind = sea::map_kind(text);
    if (!kind)
        return bad_value(kind.error().message);
    to = *kind;
    return {};
}

Result<void> read_parameter(const std::string& name, const std::string& text,
                            sea::MapRequest& request) {
    if (name == "kind")
        return read_kind(text, request.kind);
    if (name == "x0_m")
        return read_number(name, text, request.x0_m);
    if (name == "y0_m")
        return read_number(name, text, request.y0_m);
    if (name == "width_m")
        return read_number(name, text, request.width_m);
    if (name == "height_m")
        return read_number(name, text, request.height_m);
    if (name == "columns")
        return read_number(name, text, request.columns);
    if (name == "rows")
        return read_number(name, text, request.rows);
    if (name == "t_s")
        return read_time(name, text, request.time_us);
    return bad_value(fmt::format("unknown parameter \"{}\"; there are kind, x0_m, y0_m, width_m, "
                                 "height_m, columns, rows and t_s",
                                 name));
}

} // namespace

Result<sea::MapRequest> read_map_request(const std::map<std::string, std::string>& parameters,
                                         sea::TimeUs now_us) {
    sea::MapRequest request;
    request.time_us = now_us;
    for (const auto& [name, text] : parameters)
        SEAWAY_TRY(read_parameter(name, text, request));
    if (const Result<void> valid = validate(request); !valid)
        return bad_value(valid.error().message);
    return request;
}

std::uint64_t bytes_of_map(const sea::MapRequest& request) {
    return protocol::map_header_bytes +
           sizeof(float) * static_cast<std::uint64_t>(request.columns) *
               static_cast<std::uint64_t>(request.rows) *
               static_cast<std::uint64_t>(sea::map_components(request.kind));
}

Result<std::unique_ptr<ByteSource>> start_map(const sea::MapRequest& request,
                                              const sea::Surface& surface, Room::Place place,
                                              std::function<void()> on_ready) {
    sea::MapOptions options;
    options.on_ready = std::move(on_ready);
    options.pause = stand_back;
    SEAWAY_TRY_LET(std::unique_ptr<sea::MapStream> stream,
                   sea::MapStream::start(request, surface, options));
    return std::unique_ptr<ByteSource>(
        std::make_unique<MapBytes>(request, surface, std::move(stream), std::move(place)));
}

} // namespace seaway::server
