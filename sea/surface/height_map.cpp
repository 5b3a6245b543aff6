// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/height_map.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>
#include <numeric>

#include <fmt/format.h>

#include "base/check.h"
#include "base/for_want_of_memory.h"
#include "base/thread_name.h"
#include "sea/surface/maps/hermite.h"

namespace seaway::sea {

namespace {

/// Splines are linear in their coefficients: one map at the time gives what two give mixed.
std::vector<float> mixed_texels(const SplinePair& pair, TimeUs time_us) {
    constexpr std::size_t from = spline_channel::count, to = spline_channel::mixed,
                          rate = spline_channel::rate;
    const HermiteWeights w =
        hermite_weights(pair.before->time_us(), pair.after->time_us(), time_us);
    const std::span<const float> a = pair.before->coefficients();
    const std::span<const float> b = pair.after->coefficients();
    std::vector<float> mixed(a.size() / from * to);
    for (std::size_t i = 0; i < a.size() / from; ++i)
        for (std::size_t c = 0; c < spline_channel::values; ++c) {
            const std::size_t value = i * from + c;
            mixed[i * to + c] =
                static_cast<float>(w.value[0] * static_cast<double>(a[value]) +
                                   w.value[1] * static_cast<double>(a[value + rate]) +
                                   w.value[2] * static_cast<double>(b[value]) +
                                   w.value[3] * static_cast<double>(b[value + rate]));
        }
    return mixed;
}

/// Position on the tile of a world coordinate, texels, 0 .. size.
double texel_position(double x_m, double length_m, int size) {
    const double turns = x_m / length_m;
    return (turns - std::floor(turns)) * size;
}

Error out_of_range(std::string_view field, double value, std::string_view range) {
    return Error{fmt::format("map: {} = {} is out of range, {}", field, value, range)};
}

} // namespace

Result<MapKind> map_kind(std::string_view name) {
    if (name == "height")
        return MapKind::height;
    if (name == "displacement")
        return MapKind::displacement;
    if (name == "normal")
        return MapKind::normal;
    return Error{
        fmt::format("map: kind = \"{}\" is not one of height, displacement, normal", name)};
}

Result<void> validate(const MapRequest& r) {
    const auto position = [](double x) { return std::abs(x) <= position_max_m; };
    const auto extent = [](double x) { return x > 0 && x <= map_width_max_m; };
    const auto count = [](int n) { return n >= 1 && n <= map_points_a_side_max; };
    if (!position(r.x0_m))
        return out_of_range("x0_m", r.x0_m, "-1e9 .. 1e9");
    if (!position(r.y0_m))
        return out_of_range("y0_m", r.y0_m, "-1e9 .. 1e9");
    if (!extent(r.width_m))
        return out_of_range("width_m", r.width_m, "above 0, up to 1e6");
    if (!extent(r.height_m))
        return out_of_range("height_m", r.height_m, "above 0, up to 1e6");
    if (!count(r.columns))
        return out_of_range("columns", r.columns, "1 .. 4096");
    if (!count(r.rows))
        return out_of_range("rows", r.rows, "1 .. 4096");
    if (!in_time_range(r.time_us))
        return Error{fmt::format("map: time_us = {} is out of range, {} .. {}", r.time_us,
                                 -time_us_max, time_us_max)};
    return {};
}

double map_height_error_m(const Surface& surface) {
    // A slope of one, as steep as a breaking crest, or five deviations of what the sea has.
    const double slope = std::max(1.0, bound_sigmas * surface.map_error().rms_slope);
    return surface.height_bound_m(slope) + slope * map_difference_max_m;
}

const MapKernel& map_kernel(Instructions instructions) {
#if defined(SEAWAY_X86)
    if (instructions != Instructions::portable)
        return map_kernel_avx2();
#else
    SEAWAY_CHECK(instructions == Instructions::portable, "no other kernel is built");
#endif
    return map_kernel_portable();
}

// ---- the stream ------------------------------------------------------------------------------

Result<std::unique_ptr<MapStream>> MapStream::start(const MapRequest& request,
                                                    const Surface& surface, MapOptions options) {
    SEAWAY_TRY(validate(request));
    if (!surface.covers(request.time_us))
        return Error{
            fmt::format("map: time_us = {} is outside the keyframes held", request.time_us)};
    std::unique_ptr<MapStream> stream(new MapStream(request, surface, std::move(options)));
    for (int i = 0; i < stream->options_.threads; ++i)
        stream->threads_.emplace_back([self = stream.get()] { self->work(); });
    return stream;
}

MapStream::MapStream(const MapRequest& request, const Surface& surface, MapOptions options)
    : request_(request), options_(std::move(options)), kernel_(map_kernel(options_.instructions)),
      surface_(surface) {
    SEAWAY_CHECK(options_.threads >= 1 && options_.threads <= 16, "a map takes 1 .. 16 threads");
    // Room for wherever the solver may look: indices stay positive.
    const double margin_m = 100.0 + 8.0 * surface_.folds().reach_m;
    base_x_m_ = request_.x0_m - margin_m;
    base_y_m_ = request_.y0_m - margin_m;
    for (const SplinePair& pair : surface.pairs()) {
        const int size = pair.before->size();
        const double length_m = pair.before->length_m();
        SEAWAY_CHECK(std::has_single_bit(static_cast<unsigned>(size)), "tiles are powers of two");
        SEAWAY_CHECK(pair.after->size() == size, "a pair is of one cascade");
        finest_m_ = std::min(finest_m_, length_m / size);
        tiles_.push_back({nullptr, size, size + SplineMap::border, size / length_m,
                          texel_position(base_x_m_, length_m, size),
                          texel_position(base_y_m_, length_m, size)});
    }
    rows_a_chunk_ =
        std::clamp(map_chunk_values_max / (request_.columns * map_components(request_.kind)), 1,
                   request_.rows);
    chunks_ = (request_.rows + rows_a_chunk_ - 1) / rows_a_chunk_;
}

MapStream::~MapStream() {
    {
        const std::scoped_lock lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
}

struct MapStream::Scratch {
    std::vector<float> shift_x, shift_y; ///< solved, of the row before
    std::vector<int> unsolved;

    explicit Scratch(std::size_t columns) : shift_x(columns), shift_y(columns), unsolved(columns) {}
};

int MapStream::rows_of(int chunk) const {
    return std::min(rows_a_chunk_, request_.rows - chunk * rows_a_chunk_);
}

void MapStream::mix_texels() {
    for (std::size_t c = 0; c < tiles_.size() && !stopping_; ++c) {
        texels_.push_back(mixed_texels(surface_.pairs()[c], request_.time_us));
        tiles_[c].texels = texels_.back().data();
    }
}

void MapStream::work() {
    name_thread("sea-maps");
    try {
        make_chunks();
    } catch (const std::bad_alloc&) {
        {
            const std::scoped_lock lock(mutex_);
            failed_ = true;
            stopping_ = true;
        }
        changed_.notify_all();
        if (options_.on_ready) // which may need memory itself
            (void)tried_for_a_second(options_.on_ready);
    }
}

void MapStream::make_chunks() {
    std::call_once(mixed_, [&] { mix_texels(); });
    Scratch scratch(static_cast<std::size_t>(request_.columns));
    for (;;) {
        int mine = 0;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] {
                return stopping_ || next_to_compute_ >= chunks_ ||
                       next_to_compute_ < next_to_read_ + map_chunks_ahead_max;
            });
            if (stopping_ || next_to_compute_ >= chunks_)
                return;
            mine = next_to_compute_++;
        }
        MapChunk chunk = compute(mine, scratch);
        if (stopping_)
            return; // half a chunk
        bool awaited = false;
        {
            const std::scoped_lock lock(mutex_);
            ready_.emplace(mine, std::move(chunk));
            awaited = mine == next_to_read_;
        }
        changed_.notify_all();
        if (awaited && options_.on_ready)
            options_.on_ready();
    }
}

MapChunk MapStream::compute(int index, Scratch& scratch) const {
    MapChunk chunk{index * rows_a_chunk_, rows_of(index), {}};
    const auto components = static_cast<std::size_t>(map_components(request_.kind));
    const std::size_t row_values = static_cast<std::size_t>(request_.columns) * components;
    chunk.values.resize(static_cast<std::size_t>(chunk.rows) * row_values);
    std::fill(scratch.shift_x.begin(), scratch.shift_x.end(), 0.0f);
    std::fill(scratch.shift_y.begin(), scratch.shift_y.end(), 0.0f);
    for (int r = 0; r < chunk.rows && !stopping_; ++r) {
        const double y_m =
            request_.y0_m + (chunk.first_row + r) * request_.height_m / request_.rows;
        const MapRow row{tiles_.data(),
                         static_cast<int>(tiles_.size()),
                         request_.kind,
                         request_.columns,
                         request_.x0_m - base_x_m_,
                         request_.width_m / request_.columns,
                         y_m - base_y_m_,
                         static_cast<float>(surface_.choppiness().x),
                         static_cast<float>(surface_.choppiness().y),
                         last_steps_of(finest_m_),
                         scratch.shift_x.data(),
                         scratch.shift_y.data(),
                         chunk.values.data() + static_cast<std::size_t>(r) * row_values,
                         scratch.unsolved.data()};
        // Newton says nothing of other sheets: where they are common, every point is a query's.
        const bool all = surface_.folds().always && request_.kind != MapKind::displacement;
        if (all)
            std::iota(scratch.unsolved.begin(), scratch.unsolved.end(), 0);
        const int unsolved = all ? request_.columns : kernel_.row(row);
        solve_carefully(row, y_m, {scratch.unsolved.data(), static_cast<std::size_t>(unsolved)});
        pause();
    }
    return chunk;
}

void MapStream::pause() const {
    if (options_.pause != nullptr)
        options_.pause();
}

void MapStream::solve_carefully(const MapRow& row, double y_m, std::span<const int> columns) const {
    constexpr std::size_t between_pauses = 64;
    std::size_t solved = 0;
    for (const int column : columns) {
        if (stopping_)
            return;
        if (++solved % between_pauses == 0)
            pause();
        const double x_m = request_.x0_m + column * request_.width_m / request_.columns;
        const Answer answer = surface_.answer({x_m, y_m, request_.time_us});
        if (row.kind == MapKind::height) {
            row.out[column] = static_cast<float>(answer.height_m);
            continue;
        }
        for (int i = 0; i < 3; ++i)
            row.out[3 * column + i] = static_cast<float>(answer.normal[i]);
    }
}

std::optional<MapChunk> MapStream::next_chunk() {
    std::optional<MapChunk> chunk;
    {
        std::unique_lock lock(mutex_);
        if (next_to_read_ >= chunks_)
            return std::nullopt;
        changed_.wait(lock, [&] { return failed_ || ready_.count(next_to_read_) > 0; });
        if (failed_)
            return std::nullopt;
        const auto found = ready_.find(next_to_read_);
        chunk = std::move(found->second);
        ready_.erase(found);
        ++next_to_read_;
    }
    changed_.notify_all();
    return chunk;
}

bool MapStream::ready() const {
    const std::scoped_lock lock(mutex_);
    return next_to_read_ >= chunks_ || ready_.count(next_to_read_) > 0;
}

} // namespace seaway::sea
