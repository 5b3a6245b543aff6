// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/regrid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/check.h"
#include "sea/basics/dispersion.h"
#include "sea/surface/maps/line_kernel.h"

namespace seaway::sea {

namespace {

constexpr int lanes = lines_at_once;
constexpr int lines_pitch = 2 * lanes;
constexpr int side_max = 4096;

LineKernel kernel_for([[maybe_unused]] Instructions instructions) {
#if defined(SEAWAY_X86)
    if (instructions != Instructions::portable)
        return transform_lines_avx2;
#endif
    return transform_lines_portable;
}

std::size_t floats(int lines_rounded_up, int length) {
    const auto groups = static_cast<std::size_t>((lines_rounded_up + lanes - 1) / lanes);
    return groups * static_cast<std::size_t>(length) * lines_pitch;
}

/// Where a lattice index stands in a transform.
std::size_t place(int index, int length) {
    return static_cast<std::size_t>(index < 0 ? index + length : index);
}

std::size_t area(int side) {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
}

} // namespace

/// Of one thread. Columns are in groups of 16 lattice indices along x, from -reach on.
struct Regrid::Scratch {
    std::vector<float> line, other;
    std::vector<float> columns_in;  ///< [group][y][re, im][index]
    std::vector<float> columns_out; ///< likewise, y of the other grid
};

Regrid::Scratch& Regrid::scratch() {
    thread_local Scratch memory;
    return memory;
}

bool Regrid::takes(int size) {
    if (size < 1 || size > side_max)
        return false;
    for (const int r : {2, 3, 5})
        while (size % r == 0)
            size /= r;
    return size == 1;
}

int smallest_grid(double reach, int size) {
    for (int n = static_cast<int>(std::floor(2.0 * reach)) + 1; n < size; ++n)
        if (Regrid::takes(n))
            return n;
    return size;
}

double disc_share(int size) {
    int kept = 0;
    for (int y = -size / 2; y <= size / 2; ++y)
        for (int x = -size / 2; x <= size / 2; ++x)
            kept += 4 * (x * x + y * y) < size * size ? 1 : 0;
    return static_cast<double>(kept) / (static_cast<double>(size) * size);
}

Orbits::Orbits(int size, double length_m, double depth_m) : size_(size) {
    const int side = (size + 1) / 2;
    double sum = 0;
    int waves = 0;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
            const double index = std::hypot(i, j);
            const double aspect =
                index > 0 ? orbit_aspect(2.0 * std::numbers::pi * index / length_m, depth_m) : 0.0;
            over_index_.push_back(index > 0 ? static_cast<float>(aspect / index) : 0.0f);
            if (index > 0 && 4 * (i * i + j * j) < size * size) {
                const int mirrored = (i > 0 ? 2 : 1) * (j > 0 ? 2 : 1);
                sum += mirrored * aspect * aspect;
                waves += mirrored;
            }
        }
    gain_ = waves > 0 ? 0.5 * sum / waves : 0.5;
}

Regrid::Length Regrid::length_of(int n) {
    Length length{n, {}, {}};
    int left = n;
    for (const int r : {4, 2, 3, 5})
        for (; left % r == 0; left /= r)
            length.radices.push_back(r);
    left = n;
    for (const int r : length.radices) {
        for (int p = 0; p < left / r; ++p)
            for (int j = 1; j < r; ++j) {
                const double angle = -2.0 * std::numbers::pi * j * p / left;
                length.twiddles.push_back(static_cast<float>(std::cos(angle)));
                length.twiddles.push_back(static_cast<float>(std::sin(angle)));
            }
        left /= r;
    }
    return length;
}

Regrid::Regrid(int from, int to, Instructions instructions)
    : smaller_(std::min(from, to)), reach_((smaller_ - 1) / 2), instructions_(instructions) {
    SEAWAY_CHECK(takes(from) && takes(to),
                 "sides of maps that are regridded are 1 to 4096, products of 2, 3, 5");
    from_ = length_of(from);
    to_ = length_of(to);
}

void Regrid::maps(std::span<const float> a, std::span<const float> b, std::span<float> out_a,
                  std::span<float> out_b) const {
    Scratch& memory = scratch();
    take(a, b, memory);
    give(Way::height, nullptr, {out_a, out_b}, memory);
}

void Regrid::maps(std::span<const float> a, std::span<const float> b, const Orbits& orbits,
                  Two height, Two x, Two y) const {
    SEAWAY_CHECK(orbits.size() == smaller_, "orbits are of the disc that is kept");
    Scratch& memory = scratch();
    take(a, b, memory);
    give(Way::height, nullptr, height, memory);
    give(Way::along_x, &orbits, x, memory);
    give(Way::along_y, &orbits, y, memory);
}

void Regrid::maps(std::span<const float> a, std::span<const float> b, const Rotations& rotations,
                  std::span<float> out_a, std::span<float> out_b) const {
    SEAWAY_CHECK(rotations.size() == smaller_, "rotations are of the disc that is kept");
    Scratch& memory = scratch();
    take(a, b, memory);
    turn(rotations, memory);
    give(Way::height, nullptr, {out_a, out_b}, memory);
}

void Regrid::take(std::span<const float> a, std::span<const float> b, Scratch& memory) const {
    SEAWAY_CHECK(a.size() == area(from_.length) && b.size() == a.size(),
                 "maps are of the side that was said");
    make_room(memory);
    rows_in(a, b, memory);
    columns(memory);
}

void Regrid::give(Way way, const Orbits* orbits, Two out, Scratch& memory) const {
    for (const std::span<float> map : {out.a, out.b})
        SEAWAY_CHECK(map.empty() || map.size() == area(to_.length),
                     "maps are of the side that was said");
    if (out.a.empty() && out.b.empty())
        return;
    columns_back(way, orbits, memory);
    rows_out(out.a, out.b, memory);
}

void Regrid::make_room(Scratch& memory) const {
    const int longest = std::max(from_.length, to_.length);
    memory.line.resize(floats(1, longest));
    memory.other.resize(floats(1, longest));
    memory.columns_in.resize(floats(2 * reach_ + 1, from_.length));
    memory.columns_out.resize(floats(2 * reach_ + 1, to_.length));
}

void Regrid::maps(const Keyframe& keyframe, FieldSet fields, Keyframe& out) const {
    out.values.resize(static_cast<std::size_t>(out.fields.size()) * out.plane_size());
    std::vector<Field> list;
    for (const Field field : fields)
        list.push_back(field);
    std::vector<float> nobody(list.size() % 2 == 0 ? 0 : out.plane_size());
    for (std::size_t i = 0; i < list.size(); i += 2) {
        const bool alone = i + 1 == list.size();
        maps(keyframe.plane(list[i]), keyframe.plane(list[alone ? i : i + 1]), out.plane(list[i]),
             alone ? std::span(nobody) : out.plane(list[i + 1]));
    }
}

void Regrid::rows_in(std::span<const float> a, std::span<const float> b, Scratch& memory) const {
    const int n = from_.length;
    const LineTransform transform{n, from_.radices.data(), static_cast<int>(from_.radices.size()),
                                  from_.twiddles.data()};
    const LineKernel kernel = kernel_for(instructions_);
    for (int y0 = 0; y0 < n; y0 += lanes) {
        const int rows = std::min(lanes, n - y0);
        float* line = memory.line.data();
        for (int row = 0; row < rows; ++row) {
            const std::size_t first =
                static_cast<std::size_t>(y0 + row) * static_cast<std::size_t>(n);
            for (int x = 0; x < n; ++x) {
                line[x * lines_pitch + row] = a[first + static_cast<std::size_t>(x)];
                line[x * lines_pitch + lanes + row] = b[first + static_cast<std::size_t>(x)];
            }
        }
        const float* done = kernel(transform, line, memory.other.data());
        for (int i = 0; i <= 2 * reach_; ++i) {
            const float* from = done + place(i - reach_, n) * lines_pitch;
            float* to = memory.columns_in.data() +
                        (static_cast<std::size_t>(i / lanes) * static_cast<std::size_t>(n) +
                         static_cast<std::size_t>(y0)) *
                            lines_pitch +
                        i % lanes;
            for (int row = 0; row < rows; ++row, to += lines_pitch) {
                to[0] = from[row];
                to[lanes] = from[lanes + row];
            }
        }
    }
}

void Regrid::columns(Scratch& memory) const {
    const int n = from_.length;
    const LineTransform forward{n, from_.radices.data(), static_cast<int>(from_.radices.size()),
                                from_.twiddles.data()};
    const LineKernel kernel = kernel_for(instructions_);
    for (int i0 = 0; i0 <= 2 * reach_; i0 += lanes) {
        float* line =
            memory.columns_in.data() + static_cast<std::size_t>(i0 / lanes) * floats(1, n);
        const float* done = kernel(forward, line, memory.other.data());
        if (done != line)
            std::copy_n(done, floats(1, n), line);
    }
}

/// Both maps are the two parts of one transform Z = A + iB, so that with Z~(k) = conj Z(-k) the sum cA + sB + i (cB - dA)
/// of what they become is cZ - i/2 (s (Z - Z~) + d (Z + Z~)); k and -k are turned together.
void Regrid::turn(const Rotations& rotations, Scratch& memory) const {
    const int n = from_.length;
    const auto at = [&](int i, int j) {
        const int column = i + reach_;
        return memory.columns_in.data() + static_cast<std::size_t>(column / lanes) * floats(1, n) +
               place(j, n) * lines_pitch + column % lanes;
    };
    const auto turned = [](const Rotations::Turn& turn, float re, float im, float other_re,
                           float other_im, float* to) {
        const float half_s = 0.5f * turn.sine_over_w_s, half_d = 0.5f * turn.sine_w_radps;
        const float x = half_s * (re - other_re) + half_d * (re + other_re);
        const float y = half_s * (im + other_im) + half_d * (im - other_im);
        to[0] = turn.cosine * re + y;
        to[lanes] = turn.cosine * im - x;
    };
    for (int j = 0; j <= reach_; ++j)
        for (int i = -reach_; i <= reach_; ++i) {
            if (4 * (i * i + j * j) >= smaller_ * smaller_ || (j == 0 && i <= 0))
                continue;
            const Rotations::Turn& turn = rotations.of_index(i, j);
            float *one = at(i, j), *other = at(-i, -j);
            const float re = one[0], im = one[lanes];
            const float other_re = other[0], other_im = other[lanes];
            turned(turn, re, im, other_re, other_im, one);
            turned(turn, other_re, other_im, re, im, other);
        }
}

void Regrid::columns_back(Way way, const Orbits* orbits, Scratch& memory) const {
    const int n = from_.length, m = to_.length;
    const LineTransform back{m, to_.radices.data(), static_cast<int>(to_.radices.size()),
                             to_.twiddles.data()};
    const LineKernel kernel = kernel_for(instructions_);
    const float scale = 1.0f / (static_cast<float>(n) * static_cast<float>(n));
    for (int i0 = 0; i0 <= 2 * reach_; i0 += lanes) {
        const auto group = static_cast<std::size_t>(i0 / lanes);
        const float* waves = memory.columns_in.data() + group * floats(1, n);
        float* line = memory.columns_out.data() + group * floats(1, m);
        std::fill_n(line, floats(1, m), 0.0f);
        for (int j = -reach_; j <= reach_; ++j) {
            const float* from = waves + place(j, n) * lines_pitch;
            float* to = line + place(j, m) * lines_pitch;
            for (int lane = 0; lane < lanes && i0 + lane <= 2 * reach_; ++lane) {
                const int i = i0 + lane - reach_;
                if (4 * (i * i + j * j) >= smaller_ * smaller_)
                    continue;
                const float re = scale * from[lane], im = scale * from[lanes + lane];
                // Real and imaginary parts exchanged, to go back.
                if (way == Way::height) {
                    to[lane] = im;
                    to[lanes + lane] = re;
                } else if (i != 0 || j != 0) { // times i k/|k| coth(k d)
                    const auto index = static_cast<float>(way == Way::along_x ? i : j);
                    const float w = index * orbits->over_index(i, j);
                    to[lane] = w * re;
                    to[lanes + lane] = -w * im;
                }
            }
        }
        const float* result = kernel(back, line, memory.other.data());
        if (result != line)
            std::copy_n(result, floats(1, m), line);
    }
}

void Regrid::rows_out(std::span<float> a, std::span<float> b, Scratch& memory) const {
    const int m = to_.length;
    const LineTransform transform{m, to_.radices.data(), static_cast<int>(to_.radices.size()),
                                  to_.twiddles.data()};
    const LineKernel kernel = kernel_for(instructions_);
    for (int y0 = 0; y0 < m; y0 += lanes) {
        const int rows = std::min(lanes, m - y0);
        float* line = memory.line.data();
        std::fill_n(line, floats(1, m), 0.0f);
        for (int i = 0; i <= 2 * reach_; ++i) {
            const float* from = memory.columns_out.data() +
                                (static_cast<std::size_t>(i / lanes) * static_cast<std::size_t>(m) +
                                 static_cast<std::size_t>(y0)) *
                                    lines_pitch +
                                i % lanes;
            float* to = line + place(i - reach_, m) * lines_pitch;
            for (int row = 0; row < rows; ++row, from += lines_pitch) {
                to[row] = from[0];
                to[lanes + row] = from[lanes];
            }
        }
        const float* done = kernel(transform, line, memory.other.data());
        for (const auto& [map, part] : {std::pair(a, lanes), {b, 0}}) // exchanged
            for (int row = 0; row < rows && !map.empty(); ++row) {
                float* to =
                    map.data() + static_cast<std::size_t>(y0 + row) * static_cast<std::size_t>(m);
                for (int x = 0; x < m; ++x)
                    to[x] = done[x * lines_pitch + part + row];
            }
    }
}

} // namespace seaway::sea
