// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/regrid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/check.h"
#include "sea/surface/maps/line_kernel.h"

namespace seaway::sea {

namespace {

constexpr int lanes = lines_at_once;
constexpr int pitch = 2 * lanes;
constexpr int side_max = 4096;

LineKernel kernel_for(Instructions instructions) {
#if defined(SEAWAY_X86)
    if (instructions != Instructions::portable)
        return transform_lines_avx2;
#endif
    return transform_lines_portable;
}

std::size_t floats(int lines_rounded_up, int length) {
    const auto groups = static_cast<std::size_t>((lines_rounded_up + lanes - 1) / lanes);
    return groups * static_cast<std::size_t>(length) * pitch;
}

/// Where a lattice index stands in a transform.
std::size_t place(int index, int length) {
    return static_cast<std::size_t>(index < 0 ? index + length : index);
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
    const auto area = [](const Length& side) {
        return static_cast<std::size_t>(side.length) * static_cast<std::size_t>(side.length);
    };
    SEAWAY_CHECK(a.size() == area(from_) && b.size() == a.size() && out_a.size() == area(to_) &&
                     out_b.size() == out_a.size(),
                 "maps are of the sides that were said");
    Scratch& memory = scratch();
    const int longest = std::max(from_.length, to_.length);
    memory.line.resize(floats(1, longest));
    memory.other.resize(floats(1, longest));
    memory.columns_in.resize(floats(2 * reach_ + 1, from_.length));
    memory.columns_out.resize(floats(2 * reach_ + 1, to_.length));
    rows_in(a, b, memory);
    columns(memory);
    rows_out(out_a, out_b, memory);
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
                line[x * pitch + row] = a[first + static_cast<std::size_t>(x)];
                line[x * pitch + lanes + row] = b[first + static_cast<std::size_t>(x)];
            }
        }
        const float* done = kernel(transform, line, memory.other.data());
        for (int i = 0; i <= 2 * reach_; ++i) {
            const float* from = done + place(i - reach_, n) * pitch;
            float* to = memory.columns_in.data() +
                        (static_cast<std::size_t>(i / lanes) * static_cast<std::size_t>(n) +
                         static_cast<std::size_t>(y0)) *
                            pitch +
                        i % lanes;
            for (int row = 0; row < rows; ++row, to += pitch) {
                to[0] = from[row];
                to[lanes] = from[lanes + row];
            }
        }
    }
}

void Regrid::columns(Scratch& memory) const {
    const int n = from_.length, m = to_.length;
    const LineTransform forward{n, from_.radices.data(), static_cast<int>(from_.radices.size()),
                                from_.twiddles.data()};
    const LineTransform back{m, to_.radices.data(), static_cast<int>(to_.radices.size()),
                             to_.twiddles.data()};
    const LineKernel kernel = kernel_for(instructions_);
    const float scale = 1.0f / (static_cast<float>(n) * static_cast<float>(n));
    for (int i0 = 0; i0 <= 2 * reach_; i0 += lanes) {
        const auto group = static_cast<std::size_t>(i0 / lanes);
        const float* done =
            kernel(forward, memory.columns_in.data() + group * floats(1, n), memory.other.data());
        float* line = memory.columns_out.data() + group * floats(1, m);
        std::fill_n(line, floats(1, m), 0.0f);
        for (int j = -reach_; j <= reach_; ++j) {
            const float* from = done + place(j, n) * pitch;
            float* to = line + place(j, m) * pitch;
            for (int lane = 0; lane < lanes && i0 + lane <= 2 * reach_; ++lane) {
                const int i = i0 + lane - reach_;
                const bool kept = 4 * (i * i + j * j) < smaller_ * smaller_;
                // Exchanged, to go back.
                to[lane] = kept ? scale * from[lanes + lane] : 0.0f;
                to[lanes + lane] = kept ? scale * from[lane] : 0.0f;
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
                                    pitch +
                                i % lanes;
            float* to = line + place(i - reach_, m) * pitch;
            for (int row = 0; row < rows; ++row, from += pitch) {
                to[row] = from[0];
                to[lanes + row] = from[lanes];
            }
        }
        const float* done = kernel(transform, line, memory.other.data());
        for (int row = 0; row < rows; ++row) {
            const std::size_t first =
                static_cast<std::size_t>(y0 + row) * static_cast<std::size_t>(m);
            for (int x = 0; x < m; ++x) {
                a[first + static_cast<std::size_t>(x)] = done[x * pitch + lanes + row];
                b[first + static_cast<std::size_t>(x)] = done[x * pitch + row];
            }
        }
    }
}

} // namespace seaway::sea
