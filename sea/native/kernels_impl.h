// SPDX-License-Identifier: Apache-2.0
// The two passes of kernels.h, for any size and lane count. Included once per instruction set by
// a file that defines what it is compiled for; everything has internal linkage.
#pragma once

#include "sea/native/codelets.h"
#include "sea/native/kernels.h"
#include "sea/native/vector.h"

namespace seaway::sea::native {
namespace {

template <int N>
struct Factors;
// clang-format off
template <> struct Factors<16> { static constexpr int r1 = 4, r2 = 4; };
template <> struct Factors<32> { static constexpr int r1 = 4, r2 = 8; };
template <> struct Factors<64> { static constexpr int r1 = 8, r2 = 8; };
template <> struct Factors<128> { static constexpr int r1 = 8, r2 = 16; };
template <> struct Factors<256> { static constexpr int r1 = 16, r2 = 16; };
template <> struct Factors<512> { static constexpr int r1 = 16, r2 = 32; };
template <> struct Factors<1024> { static constexpr int r1 = 32, r2 = 32; };
// clang-format on

template <int N, int W>
struct Kernel {
    static constexpr int r1 = Factors<N>::r1, r2 = Factors<N>::r2;
    static constexpr int columns_lanes = W < N / 2 ? W : N / 2;
    static constexpr int row_lanes = W < r1 ? W : r1;
    static constexpr std::size_t source_floats = std::size_t(N) * 2 * columns_lanes;
    static constexpr std::size_t column_floats = (source_count + 1) * source_floats;
    static constexpr std::size_t row_floats = std::size_t(N) * 12;
    static constexpr std::size_t scratch_floats =
        column_floats > row_floats ? column_floats : row_floats;

    /// h and what is wanted of dh/dt and the two over k, on all ky of a block: [n][re, im][lane].
    static void evolve(const ColumnPass& pass, const Block& block, float* sources) {
        constexpr int L = columns_lanes;
        using V = Lanes<L>;
        using F = typename V::F;
        constexpr auto all = std::make_integer_sequence<int, L>{};
        const auto put = [&](Source source, int n, F re, F im) {
            float* to = sources + std::size_t(source) * source_floats + std::size_t(n) * 2 * L;
            store<L>(to, re);
            store<L>(to + L, im);
        };
        const std::uint32_t wanted = pass.sources;
        constexpr std::uint32_t over_k_sources = 1u << source_h_over_k | 1u << source_rate_over_k;
        for (int source = 0; source < source_count; ++source)
            for (int n = block.reach + 1;
                 (wanted >> source & 1u) && n < N - (block.reach > 0 ? block.reach : 0); ++n)
                put(Source(source), n, F{}, F{});
        std::size_t index = block.first;
        for (int ky = -block.reach; ky <= block.reach; ++ky, ++index) {
            const float* record = pass.records + index * record_streams * L;
            const int n = ky & (N - 1);
            const auto* rate = reinterpret_cast<const typename V::Half*>(record + 4 * L);
            const auto low = rate[0] * pass.time_us, high = rate[1] * pass.time_us;
            F s, c;
            using U = typename V::U;
            sincos_turns<L>(odd_words(U(low), U(high), all), s, c);
            const F pr = load<L>(record), pi = load<L>(record + L);
            const F qr = load<L>(record + 2 * L), qi = load<L>(record + 3 * L);
            const F hr = Fused::add(pr, c, qr * s), hi = Fused::add(pi, c, qi * s);
            const F over_k = wanted & over_k_sources ? load<L>(pass.over_k + index * L) : F{};
            if (wanted >> source_h & 1u)
                put(source_h, n, hr, hi);
            if (wanted >> source_h_over_k & 1u)
                put(source_h_over_k, n, hr * over_k, hi * over_k);
            if (wanted >> source_rate & 3u) {
                const F omega = load<L>(pass.omega + index * L);
                const F dr = Fused::subtract(qr, c, pr * s) * omega;
                const F di = Fused::subtract(qi, c, pi * s) * omega;
                if (wanted >> source_rate & 1u)
                    put(source_rate, n, dr, di);
                if (wanted >> source_rate_over_k & 1u)
                    put(source_rate_over_k, n, dr * over_k, di * over_k);
            }
        }
    }

    /// One base of one block along y. `middle` is scratch; `out` is this block's place in row 0.
    template <bool scaled>
    static void transform_columns(const float* source, const float* scale, const Plan& plan,
                                  float* middle, float* out, std::size_t row_pitch,
                                  std::size_t line_pitch) {
        constexpr int L = columns_lanes;
        using F = typename Lanes<L>::F;
        for (int n2 = 0; n2 < r2; ++n2) {
            codelets::Complex<F> z[r1];
#pragma GCC unroll 32
            for (int n1 = 0; n1 < r1; ++n1) {
                const int n = n1 * r2 + n2;
                const float* from = source + std::size_t(n) * 2 * L;
                z[n1] = {load<L>(from), load<L>(from + L)};
                if constexpr (scaled) {
                    z[n1].re *= scale[n];
                    z[n1].im *= scale[n];
                }
            }
            codelets::dft<F, float, Fused>(z);
#pragma GCC unroll 32
            for (int k1 = 0; k1 < r1; ++k1) {
                const float c = plan.cos[k1 * r2 + n2], s = plan.sin[k1 * r2 + n2];
                float* to = middle + std::size_t(k1 * r2 + n2) * 2 * L;
                store<L>(to, Fused::subtract(z[k1].re, c, z[k1].im * s));
                store<L>(to + L, Fused::add(z[k1].im, c, z[k1].re * s));
            }
        }
        for (int k1 = 0; k1 < r1; ++k1) {
            codelets::Complex<F> z[r2];
            if (N >= smallest_streamed_size)
                prefetch_column(out + std::size_t(k1 + 1) * row_pitch, row_pitch, line_pitch);
            const float* from = middle + std::size_t(k1 * r2) * 2 * L;
#pragma GCC unroll 32
            for (int n2 = 0; n2 < r2; ++n2)
                z[n2] = {load<L>(from + n2 * 2 * L), load<L>(from + n2 * 2 * L + L)};
            codelets::dft<F, float, Fused>(z);
#pragma GCC unroll 32
            for (int k2 = 0; k2 < r2; ++k2) {
                float* to = out + std::size_t(k1 + r1 * k2) * row_pitch;
                store<L>(to, z[k2].re);
                store<L>(to + line_pitch, z[k2].im);
            }
        }
    }

    /// Asks for the lines that the next step of transform_columns will write.
    static void prefetch_column(const float* out, std::size_t row_pitch, std::size_t line_pitch) {
        for (int k2 = 0; k2 < r2; ++k2) {
            const float* next = out + std::size_t(r1 * k2) * row_pitch;
            __builtin_prefetch(next, 1);
            __builtin_prefetch(next + line_pitch, 1);
        }
    }

    static void columns(const ColumnPass& pass, int index, float* scratch) {
        constexpr int L = columns_lanes;
        float* middle = scratch + source_count * source_floats;
        evolve(pass, pass.blocks[index], scratch);
        std::size_t wanted = 0;
        for (int base = 0; base < base_count; ++base)
            wanted += pass.bases >> base & 1u;
        const std::size_t row_pitch = wanted * 2 * pass.line_pitch;
        float* out = pass.lines + std::size_t(index) * L;
        for (int base = 0; base < base_count; ++base) {
            if (!(pass.bases >> base & 1u))
                continue;
            const float* source = scratch + std::size_t(base / 3) * source_floats;
            if (base % 3 == 0)
                transform_columns<false>(source, nullptr, pass.plan, middle, out, row_pitch,
                                         pass.line_pitch);
            else
                transform_columns<true>(source, pass.ky[base % 3], pass.plan, middle, out,
                                        row_pitch, pass.line_pitch);
            out += 2 * pass.line_pitch;
        }
        if (index + 1 == pass.block_count)
            clear_after(pass, wanted);
    }

    /// Zero lanes after the last column, which rows() reads past it.
    static void clear_after(const ColumnPass& pass, std::size_t bases) {
        constexpr int L = columns_lanes;
        float* out = pass.lines + std::size_t(pass.block_count) * L;
        for (std::size_t line = 0; line < std::size_t(N) * bases * 2; ++line)
            store<L>(out + line * pass.line_pitch, typename Lanes<L>::F{});
    }

    /// C = A + i B on all kx from the half spectra of rows y and y + 1: [re][n], [im][n].
    static void join(const float* a, const float* b, std::size_t line_pitch, int columns,
                     float mirror, float* joined) {
        constexpr int L = row_lanes;
        using F = typename Lanes<L>::F;
        for (int n = 0; n < N / 2 && n < columns; n += L) {
            const F ar = load<L>(a + n), ai = load<L>(a + line_pitch + n);
            const F br = load<L>(b + n), bi = load<L>(b + line_pitch + n);
            store<L>(joined + n, ar - bi);
            store<L>(joined + N + n, ai + br);
        }
        // n = N - kx: the lanes run down from kx = `top`, the spectra are conjugate,
        // and negative where ky stands in an odd power.
        for (int top = N / 2 < columns ? N / 2 : columns; top > 0; top -= L) {
            const int kx = top - (L - 1), n = N - top;
            const F ar = load_unaligned<L>(a + kx), ai = load_unaligned<L>(a + line_pitch + kx);
            const F br = load_unaligned<L>(b + kx), bi = load_unaligned<L>(b + line_pitch + kx);
            store<L>(joined + n, reverse<L>((ar + bi) * mirror));
            store<L>(joined + N + n, reverse<L>((br - ai) * mirror));
        }
    }

    /// One field of two rows along x.
    template <bool scaled, bool imaginary>
    static void transform_rows(const float* joined, const float* scale, const Plan& plan,
                               float* middle, float* out0, float* out1) {
        constexpr int L = row_lanes;
        using F = typename Lanes<L>::F;
        for (int n2 = 0; n2 < r2; n2 += L) {
            codelets::Complex<F> z[r1];
#pragma GCC unroll 32
            for (int n1 = 0; n1 < r1; ++n1) {
                const int n = n1 * r2 + n2;
                z[n1] = {load<L>(joined + n), load<L>(joined + N + n)};
                if constexpr (scaled) {
                    const F m = load<L>(scale + n);
                    z[n1].re *= m;
                    z[n1].im *= m;
                }
            }
            codelets::dft<F, float, Fused>(z);
            F re[r1], im[r1];
#pragma GCC unroll 32
            for (int k1 = 0; k1 < r1; ++k1) {
                const F c = load<L>(plan.cos + k1 * r2 + n2), s = load<L>(plan.sin + k1 * r2 + n2);
                re[k1] = Fused::subtract(z[k1].re, c, z[k1].im * s);
                im[k1] = Fused::add(z[k1].im, c, z[k1].re * s);
            }
            // From lanes n2 to lanes k1.
#pragma GCC unroll 8
            for (int k1 = 0; k1 < r1; k1 += L) {
                transpose<L>(re + k1);
                transpose<L>(im + k1);
#pragma GCC unroll 16
                for (int j = 0; j < L; ++j) {
                    store<L>(middle + (n2 + j) * r1 + k1, re[k1 + j]);
                    store<L>(middle + N + (n2 + j) * r1 + k1, im[k1 + j]);
                }
            }
        }
        for (int k1 = 0; k1 < r1; k1 += L) {
            codelets::Complex<F> z[r2];
#pragma GCC unroll 32
            for (int n2 = 0; n2 < r2; ++n2)
                z[n2] = {load<L>(middle + n2 * r1 + k1), load<L>(middle + N + n2 * r1 + k1)};
            codelets::dft<F, float, Fused>(z);
#pragma GCC unroll 32
            for (int k2 = 0; k2 < r2; ++k2) {
                store_unaligned<L>(out0 + k1 + r1 * k2, imaginary ? -z[k2].im : z[k2].re);
                store_unaligned<L>(out1 + k1 + r1 * k2, imaginary ? z[k2].re : z[k2].im);
            }
        }
    }

    static void jacobian(const float* xx, const float* yy, const float* xy, const float* choppiness,
                         float* out) {
        constexpr int L = row_lanes;
        using F = typename Lanes<L>::F;
        const float x = choppiness[0], y = choppiness[1];
        for (int i = 0; i < 2 * N; i += L) {
            const F one = Fused::all<F>(1.0f), cross = load_unaligned<L>(xy + i);
            store_unaligned<L>(out + i,
                               Fused::subtract(Fused::add(load_unaligned<L>(xx + i), x, one),
                                               Fused::add(load_unaligned<L>(yy + i), y, one),
                                               cross * cross * (x * y)));
        }
    }

    static void transform_field(const RowField& field, const float* joined, const Plan& plan,
                                float* middle, float* out) {
        const auto transform =
            field.imaginary
                ? (field.scale ? transform_rows<true, true> : transform_rows<false, true>)
                : (field.scale ? transform_rows<true, false> : transform_rows<false, false>);
        transform(joined, field.scale, plan, middle, out, out + N);
    }

    /// Asks for the lines of two rows that will be written, while others are being computed.
    static void prefetch_rows(const float* out) {
        for (int i = 0; i < 2 * N; i += 16)
            __builtin_prefetch(out + i, 1);
    }

    static void rows(const RowPass& pass, int y_begin, int y_end, float* scratch) {
        float* joined = scratch;
        float* middle = scratch + 2 * N;
        float* strains = scratch + 4 * N;
        float* staged = scratch + 10 * N;
        const std::size_t row_pitch = std::size_t(pass.base_count) * 2 * pass.line_pitch;
        for (int n = pass.columns; n <= N - pass.columns; ++n)
            joined[n] = joined[N + n] = 0;
        for (int y = y_begin; y < y_end; y += 2) {
            const float* line = pass.lines + std::size_t(y) * row_pitch;
            const auto rows_of = [&](const RowField& field) {
                return field.out ? field.out + std::size_t(y) * N
                                 : strains + field.scratch_row * 2 * N;
            };
            for (int i = 0; i < pass.field_count; ++i) {
                const RowField& field = pass.fields[i];
                if (i == 0 || field.base != pass.fields[i - 1].base) {
                    const float* a = line + std::size_t(field.base) * 2 * pass.line_pitch;
                    join(a, a + row_pitch, pass.line_pitch, pass.columns,
                         pass.odd_bases >> field.base & 1u ? -1.0f : 1.0f, joined);
                }
                float* out = rows_of(field);
                if (can_stream && field.streamed) {
                    transform_field(field, joined, pass.plan, middle, staged);
                    stream_past_caches<W>(out, staged, 2 * N);
                    continue;
                }
                if (N >= smallest_prefetched_size) {
                    const bool last = i + 1 == pass.field_count;
                    prefetch_rows(rows_of(pass.fields[last ? 0 : i + 1]) + (last ? 2 * N : 0));
                }
                transform_field(field, joined, pass.plan, middle, out);
            }
            if (pass.jacobian)
                jacobian(rows_of(pass.fields[pass.strain[0]]), rows_of(pass.fields[pass.strain[1]]),
                         rows_of(pass.fields[pass.strain[2]]), pass.choppiness,
                         pass.jacobian + std::size_t(y) * N);
        }
        if constexpr (can_stream)
            finish_streams();
    }

    static float product_then_sum(float a, float b, float c) {
        return a * b + c;
    }

    static constexpr Kernels value = {N,    columns_lanes,   r1, r2, scratch_floats, columns,
                                      rows, product_then_sum};
};

template <int W>
const Kernels* kernels_of(int size) {
    switch (size) {
    case 16:
        return &Kernel<16, W>::value;
    case 32:
        return &Kernel<32, W>::value;
    case 64:
        return &Kernel<64, W>::value;
    case 128:
        return &Kernel<128, W>::value;
    case 256:
        return &Kernel<256, W>::value;
    case 512:
        return &Kernel<512, W>::value;
    case 1024:
        return &Kernel<1024, W>::value;
    default:
        return nullptr;
    }
}

} // namespace
} // namespace seaway::sea::native
