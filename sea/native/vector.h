// SPDX-License-Identifier: Apache-2.0
// Lanes<W>: W floats side by side, and the few operations on them that are not plain arithmetic.
// Included by the kernels only, once per instruction set: everything has internal linkage.
//
// A product and a sum are rounded once where Fused is called and twice where * and + stand: files that
// include this are compiled with -ffp-contract=off, and no compiler fuses what is not written so. A
// value then does not depend on which code around it the compiler saw.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace seaway::sea::native {
namespace {

template <int W>
struct Lanes {
    typedef float F __attribute__((vector_size(W * 4)));
    typedef float Unaligned __attribute__((vector_size(W * 4), aligned(4), may_alias));
    typedef std::int32_t I __attribute__((vector_size(W * 4)));
    typedef std::uint32_t U __attribute__((vector_size(W * 4)));
    typedef std::uint64_t Half __attribute__((vector_size(W * 4)));
    typedef double Pairs __attribute__((vector_size(W * 4)));
};

#define SEAWAY_INLINE [[gnu::always_inline]] inline

/// Sums of products: rounded once where the instruction set does so, else product and sum. Factors
/// may be one float for all lanes.
struct Fused {
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
    static constexpr bool rounds_once = true;
#else
    static constexpr bool rounds_once = false;
#endif
    template <class F>
    SEAWAY_INLINE static F all(float s) {
        return s - F{};
    }
    /// a b + c
    template <class F>
    SEAWAY_INLINE static F add(F a, F b, F c) {
#if defined(__AVX512F__)
        if constexpr (sizeof(F) == 64)
            return _mm512_fmadd_ps(a, b, c);
#endif
#if defined(__FMA__)
        if constexpr (sizeof(F) == 32)
            return _mm256_fmadd_ps(a, b, c);
        if constexpr (sizeof(F) == 16)
            return _mm_fmadd_ps(a, b, c);
#elif defined(__ARM_FEATURE_FMA)
        F sum;
        for (std::size_t i = 0; i < sizeof(F) / sizeof(float); ++i)
            sum[i] = __builtin_fmaf(a[i], b[i], c[i]); // one instruction for all lanes
        return sum;
#endif
        return a * b + c;
    }
    /// a b - c
    template <class F>
    SEAWAY_INLINE static F subtract(F a, F b, F c) {
        return add(a, b, -c);
    }
    /// c - a b
    template <class F>
    SEAWAY_INLINE static F subtract_from(F c, F a, F b) {
        return add(-a, b, c);
    }
    template <class F>
    SEAWAY_INLINE static F add(F a, float s, F c) {
        return add(a, all<F>(s), c);
    }
    template <class F>
    SEAWAY_INLINE static F subtract(F a, float s, F c) {
        return subtract(a, all<F>(s), c);
    }
    template <class F>
    SEAWAY_INLINE static F subtract_from(F c, F a, float s) {
        return subtract_from(c, a, all<F>(s));
    }
};

template <int W>
SEAWAY_INLINE typename Lanes<W>::F load(const float* p) {
    return *reinterpret_cast<const typename Lanes<W>::F*>(p);
}
template <int W>
SEAWAY_INLINE typename Lanes<W>::F load_unaligned(const float* p) {
    return *reinterpret_cast<const typename Lanes<W>::Unaligned*>(p);
}
template <int W>
SEAWAY_INLINE void store(float* p, typename Lanes<W>::F v) {
    *reinterpret_cast<typename Lanes<W>::F*>(p) = v;
}
template <int W>
SEAWAY_INLINE void store_unaligned(float* p, typename Lanes<W>::F v) {
    *reinterpret_cast<typename Lanes<W>::Unaligned*>(p) = v;
}

/// Copies past the caches, whole lines where lines are whole; finish_streams() before another
/// thread may look.
#if defined(__SSE2__)
inline constexpr bool can_stream = true;
template <int W>
SEAWAY_INLINE void stream_line(float* to, const float* from) {
#if defined(__AVX512F__)
    if constexpr (W == 16)
        return _mm512_stream_ps(to, _mm512_loadu_ps(from));
#endif
#if defined(__AVX__)
    if constexpr (W >= 8) {
        _mm256_stream_ps(to, _mm256_loadu_ps(from));
        return _mm256_stream_ps(to + 8, _mm256_loadu_ps(from + 8));
    }
#endif
    for (int i = 0; i < 16; i += 4)
        _mm_stream_ps(to + i, _mm_loadu_ps(from + i));
}
template <int W>
SEAWAY_INLINE void stream_past_caches(float* to, const float* from, int count) {
    constexpr int line = 16;
    int i = 0;
    for (; i < count && reinterpret_cast<std::uintptr_t>(to + i) % 64 != 0; ++i)
        to[i] = from[i];
    for (; i + line <= count; i += line)
        stream_line<W>(to + i, from + i);
    for (; i < count; ++i)
        to[i] = from[i];
}
SEAWAY_INLINE void finish_streams() {
    _mm_sfence();
}
#else
inline constexpr bool can_stream = false;
template <int W>
SEAWAY_INLINE void stream_past_caches(float*, const float*, int) {}
SEAWAY_INLINE void finish_streams() {}
#endif

template <class V, int... i>
SEAWAY_INLINE V reversed(V v, std::integer_sequence<int, i...>) {
    return __builtin_shufflevector(v, v, (int(sizeof...(i)) - 1 - i)...);
}
template <int W>
SEAWAY_INLINE typename Lanes<W>::F reverse(typename Lanes<W>::F v) {
    return reversed(v, std::make_integer_sequence<int, W>{});
}

/// The high words of W 64-bit numbers in two vectors.
template <class U, int... i>
SEAWAY_INLINE U odd_words(U a, U b, std::integer_sequence<int, i...>) {
    return __builtin_shufflevector(a, b, (2 * i + 1)...);
}

// Shuffles within 16-byte groups, as every x86 set has them.
template <class V, int... i>
SEAWAY_INLINE V low_words(V a, V b, std::integer_sequence<int, i...>) {
    constexpr int W = sizeof...(i);
    return __builtin_shufflevector(a, b, (i / 4 * 4 + i % 4 / 2 + i % 2 * W)...);
}
template <class V, int... i>
SEAWAY_INLINE V high_words(V a, V b, std::integer_sequence<int, i...>) {
    constexpr int W = sizeof...(i);
    return __builtin_shufflevector(a, b, (i / 4 * 4 + 2 + i % 4 / 2 + i % 2 * W)...);
}
template <class V, int... i>
SEAWAY_INLINE V low_pairs(V a, V b, std::integer_sequence<int, i...>) {
    constexpr int W = sizeof...(i);
    return __builtin_shufflevector(a, b, (i / 4 * 4 + i % 2 + i % 4 / 2 * W)...);
}
template <class V, int... i>
SEAWAY_INLINE V high_pairs(V a, V b, std::integer_sequence<int, i...>) {
    constexpr int W = sizeof...(i);
    return __builtin_shufflevector(a, b, (i / 4 * 4 + 2 + i % 2 + i % 4 / 2 * W)...);
}
/// Every second 16-byte group of a, then of b.
template <int first, class V, int... i>
SEAWAY_INLINE V groups(V a, V b, std::integer_sequence<int, i...>) {
    constexpr int W = sizeof...(i);
    return __builtin_shufflevector(
        a, b, ((first + 2 * (i / 4 % (W / 8))) * 4 + i % 4 + (i >= W / 2 ? W : 0))...);
}

/// W vectors of W lanes: v[i] lane j <-> v[j] lane i.
template <int W>
SEAWAY_INLINE void transpose(typename Lanes<W>::F* v) {
    using F = typename Lanes<W>::F;
    constexpr auto all = std::make_integer_sequence<int, W>{};
    F t[W];
#pragma GCC unroll 16
    for (int q = 0; q < W; q += 4) {
        const F a = low_words(v[q], v[q + 1], all), b = high_words(v[q], v[q + 1], all);
        const F c = low_words(v[q + 2], v[q + 3], all), d = high_words(v[q + 2], v[q + 3], all);
        t[q] = low_pairs(a, c, all);
        t[q + 1] = high_pairs(a, c, all);
        t[q + 2] = low_pairs(b, d, all);
        t[q + 3] = high_pairs(b, d, all);
    }
    // t[q + j], 16-byte group g: column 4 g + j of rows q .. q + 3.
#pragma GCC unroll 4
    for (int j = 0; j < 4; ++j) {
        if constexpr (W == 4) {
            v[j] = t[j];
        } else if constexpr (W == 8) {
            v[j] = groups<0>(t[j], t[4 + j], all);
            v[4 + j] = groups<1>(t[j], t[4 + j], all);
        } else {
            const F a = groups<0>(t[j], t[4 + j], all), b = groups<1>(t[j], t[4 + j], all);
            const F c = groups<0>(t[8 + j], t[12 + j], all),
                    d = groups<1>(t[8 + j], t[12 + j], all);
            v[j] = groups<0>(a, c, all);
            v[8 + j] = groups<1>(a, c, all);
            v[4 + j] = groups<0>(b, d, all);
            v[12 + j] = groups<1>(b, d, all);
        }
    }
}

/// sin and cos of 2 pi turns / 2^32 with an error below 1e-7: quadrant by integer, remainder in
/// [-pi/4, pi/4], minimax polynomials (Cephes sinf, cosf).
template <int W>
SEAWAY_INLINE void sincos_turns(typename Lanes<W>::U turns, typename Lanes<W>::F& sine,
                                typename Lanes<W>::F& cosine) {
    using F = typename Lanes<W>::F;
    using I = typename Lanes<W>::I;
    using U = typename Lanes<W>::U;
    const U quadrant = (turns + 0x20000000u) >> 30;
    const F x = __builtin_convertvector(I(turns - (quadrant << 30)), F) * 1.4629180792671596e-09f;
    const F xx = x * x;
    const auto line = [](F at, float slope, float start) {
        return Fused::add(at, slope, Fused::all<F>(start));
    };
    const F s_rest = Fused::add(line(xx, -1.9515295891e-4f, 8.3321608736e-3f), xx,
                                Fused::all<F>(-1.6666654611e-1f));
    const F s = Fused::add(x * xx, s_rest, x);
    const F c_rest = Fused::add(line(xx, 2.443315711809948e-5f, -1.388731625493765e-3f), xx,
                                Fused::all<F>(4.166664568298827e-2f));
    const F c = Fused::add(xx * xx, c_rest, line(xx, -0.5f, 1.0f));
    const I odd = I(quadrant << 31) != 0;
    const U sine_sign = (quadrant & 2u) << 30, cosine_sign = ((quadrant + 1u) & 2u) << 30;
    sine = F(U(odd ? c : s) ^ sine_sign);
    cosine = F(U(odd ? s : c) ^ cosine_sign);
}

} // namespace
} // namespace seaway::sea::native
