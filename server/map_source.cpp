// SPDX-License-Identifier: Apache-2.0
#include "server/map_source.h"

#include <charconv>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace seaway::server {

namespace {

/// A sea::MapStream as bytes: its header, then rows of float32.
class MapBytes final : public ByteSource {
  public:
    MapBytes(const sea::MapRequest& request, const sea::Surface& surface,
             std::unique_ptr<sea::MapStream> stream, std::shared_ptr<void> place)
        : place_(std::move(place)), header_(map_header(request, surface)),
          size_(sea::map_header_bytes +
                sizeof(float) * static_cast<std::uint64_t>(request.columns) *
                    static_cast<std::uint64_t>(request.rows) *
                    static_cast<std::uint64_t>(sea::map_components(request.kind))),
          stream_(std::move(stream)) {}

    std::uint64_t size() const override { return size_; }

    std::vector<std::uint8_t> next() override {
        if (!header_sent_) {
            header_sent_ = true;
            return {header_.begin(), header_.end()};
        }
        if (!stream_->ready())
            return {};
        const std::optional<sea::MapChunk> chunk = stream_->next_chunk();
        if (!chunk)
            return {};
        std::vector<std::uint8_t> bytes(chunk->values.size() * sizeof(float));
        std::memcpy(bytes.data(), chunk->values.data(), bytes.size());
        return bytes;
    }

  private:
    std::shared_ptr<void> place_; ///< given back last
    std::array<std::uint8_t, sea::map_header_bytes> header_;
    std::uint64_t size_;
    bool header_sent_ = false;
    std::unique_ptr<sea::MapStream> stream_;
};

/// The whole text as a number, or an error that names the parameter.
template <class T>
Result<void> read_number(const std::string& name, const std::string& text, T& to) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
    if (error != std::errc() || end != text.data() + text.size())
        return Error{fmt::format("{} = \"{}\" is not a number", name, text)};
    return {};
}

} // namespace

Result<sea::MapRequest> read_map_request(const std::map<std::string, std::string>& parameters,
                                         sea::TimeUs now_us) {
    sea::MapRequest request;
    request.time_us = now_us;
    for (const auto& [name, text] : parameters) {
        Result<void> read;
        if (name == "kind") {
            const Result<sea::MapKind> kind = sea::map_kind(text);
            if (!kind)
                return kind.error();
            request.kind = *kind;
        } else if (name == "x0_m") {
            read = read_number(name, text, request.x0_m);
        } else if (name == "y0_m") {
            read = read_number(name, text, request.y0_m);
        } else if (name == "width_m") {
            read = read_number(name, text, request.width_m);
        } else if (name == "height_m") {
            read = read_number(name, text, request.height_m);
        } else if (name == "columns") {
            read = read_number(name, text, request.columns);
        } else if (name == "rows") {
            read = read_number(name, text, request.rows);
        } else if (name == "t_s") {
            double t_s = 0;
            read = read_number(name, text, t_s);
            if (read && !(std::abs(t_s) <= 1e12))
                return Error{fmt::format("t_s = {} is out of range, -1e12 .. 1e12", text)};
            if (read)
                request.time_us = sea::us_from_seconds(t_s);
        } else {
            return Error{
                fmt::format("unknown parameter \"{}\"; there are kind, x0_m, y0_m, width_m, "
                            "height_m, columns, rows and t_s",
                            name)};
        }
        if (!read)
            return read.error();
    }
    if (const Result<void> valid = validate(request); !valid)
        return valid.error();
    return request;
}

std::shared_ptr<void> take_map_place(const std::shared_ptr<std::atomic<int>>& running) {
    if (running->fetch_add(1) >= maps_at_once_max) {
        running->fetch_sub(1);
        return nullptr;
    }
    return {running.get(), [running](void*) { running->fetch_sub(1); }};
}

MapAnswer start_map(const sea::MapRequest& request, const sea::Surface& surface,
                    std::shared_ptr<void> place, std::function<void()> on_ready) {
    sea::MapOptions options;
    options.on_ready = std::move(on_ready);
    Result<std::unique_ptr<sea::MapStream>> stream =
        sea::MapStream::start(request, surface, options);
    if (!stream)
        return {nullptr, 400, stream.error().message};
    return {
        std::make_unique<MapBytes>(request, surface, std::move(stream).value(), std::move(place))};
}

} // namespace seaway::server
