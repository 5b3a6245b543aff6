// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/spline_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "sea/surface/maps/spline_weights.h"

namespace seaway::sea {

namespace {

constexpr float pole = -0.26794919243112270647f; // sqrt(3) - 2
constexpr float gain = 6.0f;

constexpr std::array<Field, 6> channel_fields{
    Field::height,      Field::displacement_x,      Field::displacement_y,
    Field::height_rate, Field::displacement_x_rate, Field::displacement_y_rate};
constexpr std::array<int, 6> channel_of{spline_channel::height,
                                        spline_channel::displacement_x,
                                        spline_channel::displacement_y,
                                        spline_channel::height + spline_channel::rate,
                                        spline_channel::displacement_x + spline_channel::rate,
                                        spline_channel::displacement_y + spline_channel::rate};

/// Periodic cubic B-spline prefilter of `count` samples, `stride` floats apart, for `width`
/// neighbouring floats at once. The filter's memory is 2e-9 after 15 samples.
void prefilter(float* first, int count, std::size_t stride, std::size_t width) {
    constexpr int memory = 15;
    const auto row = [&](int i) { return first + static_cast<std::size_t>(i) * stride; };
    std::vector<float> carry(width);
    const auto step = [&](float* out, float factor) {
        for (std::size_t c = 0; c < width; ++c)
            out[c] = carry[c] = factor * out[c] + pole * carry[c];
    };
    // Causal: c+[i] = s[i] + pole c+[i-1], started from the samples before the first (periodic).
    std::fill(carry.begin(), carry.end(), 0.0f);
    for (int i = count - std::min(memory, count); i < count; ++i)
        for (std::size_t c = 0; c < width; ++c)
            carry[c] = row(i)[c] + pole * carry[c];
    for (int i = 0; i < count; ++i)
        step(row(i), 1.0f);
    // Anticausal: c[i] = -6 pole c+[i] + pole c[i+1], started from those after the last.
    std::fill(carry.begin(), carry.end(), 0.0f);
    for (int i = std::min(memory, count) - 1; i >= 0; --i)
        for (std::size_t c = 0; c < width; ++c)
            carry[c] = -pole * gain * row(i)[c] + pole * carry[c];
    for (int i = count - 1; i >= 0; --i)
        step(row(i), -pole * gain);
}

typedef float F4 __attribute__((vector_size(16)));

struct GridPosition {
    int index;
    float fraction;
};

GridPosition grid_position(double x_m, double length_m, int size) {
    // Reduced in double before anything becomes float (hard cases G1, G2).
    const double turns = x_m / length_m;
    const double u = (turns - std::floor(turns)) * size;
    // A search in a map without bounds may ask where there is no number.
    const int index = u < size - 1 ? static_cast<int>(u) : size - 1;
    return {index, static_cast<float>(u - index)};
}

} // namespace

float* SplineMap::texel(int x, int y) {
    const auto pitch = static_cast<std::size_t>(size_ + border);
    return coefficients_.get() +
           (static_cast<std::size_t>(y + 1) * pitch + static_cast<std::size_t>(x + 1)) * channels;
}

SplineMap::SplineMap(const Keyframe& keyframe, Pauses::Pause pause)
    : size_(keyframe.size), length_m_(keyframe.length_m), time_us_(keyframe.time_us),
      epoch_(keyframe.epoch),
      moves_sideways_(keyframe.fields.contains(surface_fields) && !keyframe.stylised) {
    SEAWAY_CHECK(keyframe.fields.contains(FieldSet{Field::height, Field::height_rate}),
                 "a sampler needs height and its rate");
    const auto pitch = static_cast<std::size_t>(size_ + border);
    coefficients_ = allocate_floats(count_of(size_));
    const std::vector<float> none(keyframe.plane_size());
    std::array<const float*, channel_fields.size()> of;
    for (std::size_t f = 0; f < of.size(); ++f)
        of[f] = keyframe.fields.contains(channel_fields[f])
                    ? keyframe.plane(channel_fields[f]).data()
                    : none.data();
    static_assert(channel_of == std::array{0, 1, 2, 4, 5, 6});
    Pauses pauses(pause);
    for (int y = 0; y < size_;
         ++y) { // all channels of a point at once: they are half a line of a cache
        float* to = texel(0, y);
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(size_);
        for (std::size_t i = row; i < row + static_cast<std::size_t>(size_); ++i, to += channels) {
            const F4 values{of[0][i], of[1][i], of[2][i], 0},
                rates{of[3][i], of[4][i], of[5][i], 0};
            std::memcpy(to, &values, sizeof values);
            std::memcpy(to + spline_channel::rate, &rates, sizeof rates);
        }
        pauses.after(static_cast<std::size_t>(size_));
    }
    const auto side = static_cast<std::size_t>(size_);
    for (int y = 0; y < size_; ++y) {
        prefilter(texel(0, y), size_, channels, channels);
        pauses.after(2 * side);
    }
    const auto columns =
        static_cast<int>(std::clamp(Pauses::between / 2 / side, std::size_t{1}, side));
    for (int x = 0; x < size_; x += columns) { // as many at once as are done between two pauses
        const int some = std::min(columns, size_ - x);
        prefilter(texel(x, 0), size_, pitch * channels, static_cast<std::size_t>(some) * channels);
        pauses.after(2 * side * static_cast<std::size_t>(some));
    }

    const auto copy = [&](int to_x, int to_y, int from_x, int from_y) {
        std::copy_n(texel(from_x, from_y), channels, texel(to_x, to_y));
    };
    for (int y = 0; y < size_; ++y) {
        copy(-1, y, size_ - 1, y);
        copy(size_, y, 0, y);
        copy(size_ + 1, y, 1 % size_, y);
    }
    for (int x = -1; x <= size_ + 1; ++x) {
        copy(x, -1, x, size_ - 1);
        copy(x, size_, x, 0);
        copy(x, size_ + 1, x, 1 % size_);
    }
    windows_.emplace(coefficients_.get(), size_, length_m_, pauses);
}

SplineMap::Cell SplineMap::cell(double x_m, double y_m) const {
    const GridPosition gx = grid_position(x_m, length_m_, size_);
    const GridPosition gy = grid_position(y_m, length_m_, size_);
    const auto pitch = static_cast<std::size_t>(size_ + border);
    const float* first = coefficients_.get() + (static_cast<std::size_t>(gy.index) * pitch +
                                                static_cast<std::size_t>(gx.index)) *
                                                   channels;
    for (std::size_t j = 0; j < 4; ++j) {
        // Four texels of 32 bytes: two lines of a cache, or three.
        const float* row = first + j * pitch * channels;
        __builtin_prefetch(row);
        __builtin_prefetch(row + 2 * channels);
        __builtin_prefetch(row + 4 * channels - 1);
    }
    return {first, gx.fraction, gy.fraction};
}

SplineSample SplineMap::sample(const Cell& cell) const {
    F4 wx, dx, wy, dy;
    spline_weights(cell.fraction_x, wx, dx);
    spline_weights(cell.fraction_y, wy, dy);
    const auto per_m = static_cast<float>(size_ / length_m_);
    const std::size_t pitch = static_cast<std::size_t>(size_ + border) * channels;

    // By halves: values, then their time rates.
    SplineSample sample;
    for (int half = 0; half < channels; half += 4) {
        F4 value{}, by_x{}, by_y{};
        const float* row = cell.first + half;
        for (int j = 0; j < 4; ++j, row += pitch) {
            F4 across{}, slope{};
            for (int i = 0; i < 4; ++i) {
                F4 texel;
                std::memcpy(&texel, row + i * channels, sizeof texel);
                across += wx[i] * texel;
                slope += dx[i] * texel;
            }
            value += wy[j] * across;
            by_x += wy[j] * slope;
            by_y += dy[j] * across;
        }
        by_x *= per_m;
        by_y *= per_m;
        std::memcpy(sample.value + half, &value, sizeof value);
        std::memcpy(sample.d_dx + half, &by_x, sizeof by_x);
        std::memcpy(sample.d_dy + half, &by_y, sizeof by_y);
    }
    return sample;
}

} // namespace seaway::sea
