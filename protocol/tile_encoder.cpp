// SPDX-License-Identifier: Apache-2.0
// Encoder of tile codec v1 (protocol/tile_codec.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "protocol/checksum.h"
#include "protocol/tile_layout.h"
#include "protocol/zstd_memory.h"

namespace seaway::protocol {
namespace {

using namespace tile_layout;

constexpr int zstd_level = 3;

/// Working memory of one thread, at most 1.5 MB: taken once, so that the steady state allocates
/// only the bytes that it returns.
struct Scratch {
    std::vector<std::uint32_t> residuals;
    std::vector<std::int32_t> lattice; ///< what samples that are coded as differences come to
    std::vector<std::uint32_t> row;
    std::vector<std::uint32_t> row_above;
    std::vector<std::uint8_t> planes;
    std::vector<std::uint8_t> compressed;
    ZstdEncoder encoder;
};

Scratch& scratch() {
    thread_local Scratch memory;
    return memory;
}

struct Survey {
    float magnitude_max;
    bool finite;
    bool constant;
};

Survey survey(std::span<const float> samples, TileShape shape, std::size_t row_stride) {
    const auto first = std::bit_cast<std::uint32_t>(samples[0]);
    std::uint32_t magnitude_max = 0;
    std::uint32_t differences = 0;
    for (int y = 0; y < shape.height; ++y) {
        const float* row = samples.data() + static_cast<std::size_t>(y) * row_stride;
        for (int x = 0; x < shape.width; ++x) {
            const auto bits = std::bit_cast<std::uint32_t>(row[x]);
            magnitude_max = std::max(magnitude_max, bits & 0x7fffffffu);
            differences |= bits ^ first;
        }
    }
    return {.magnitude_max = std::bit_cast<float>(magnitude_max),
            .finite = magnitude_max < 0x7f800000u,
            .constant = differences == 0};
}

/// The widest step that keeps |decoded - original| <= error after the decoder's one rounding to
/// float (hard case F6); 0 where floats of this size are too coarse for quantising to pay.
float choose_step(float magnitude_max, float error) {
    if (!(error > 0))
        return 0;
    const float largest_decoded = magnitude_max + error;
    if (!std::isfinite(largest_decoded))
        return 0;
    const double ulp = static_cast<double>(std::nextafter(largest_decoded,
                                                          std::numeric_limits<float>::infinity())) -
                       static_cast<double>(largest_decoded);
    const double wanted = 2.0 * (static_cast<double>(error) - 0.5 * ulp);
    if (!(wanted > ulp) || wanted > static_cast<double>(step_max))
        return 0;
    auto step = static_cast<float>(wanted);
    if (static_cast<double>(step) > wanted)
        step = std::nextafter(step, 0.0f);
    if (static_cast<double>(magnitude_max) >= quantum_max * static_cast<double>(step))
        return 0;
    return step;
}

struct StepSurvey {
    int magnitude_max;
    bool constant;
};

StepSurvey survey(std::span<const std::int16_t> steps, TileShape shape, std::size_t row_stride) {
    std::int16_t least = steps[0], most = steps[0];
    for (int y = 0; y < shape.height; ++y) {
        const std::int16_t* row = steps.data() + static_cast<std::size_t>(y) * row_stride;
        for (int x = 0; x < shape.width; ++x) {
            least = std::min(least, row[x]);
            most = std::max(most, row[x]);
        }
    }
    return {std::max<int>(-least, most), least == most};
}

/// The widest odd number of steps whose half, rounded down, is within `error` after the decoder's rounding, and that of the
/// sample itself.
int factor_within(int magnitude_max, float step, float error) {
    constexpr int factor_max = 4095;
    const float largest = static_cast<float>(magnitude_max) * step + error;
    const double ulp =
        static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity())) -
        static_cast<double>(largest);
    const double half = std::floor((static_cast<double>(error) - ulp) / static_cast<double>(step));
    return 2 * static_cast<int>(std::clamp(half, 0.0, 0.5 * (factor_max - 1))) + 1;
}

/// The nearest multiples of an odd factor, of which `to_whole` is the inverse. Adding 1.5 * 2^23 rounds to the nearest
/// integer; no integer lies in the middle of two multiples, nor nearer to it than 32767 products are off in single
/// precision.
void multiples_row(const std::int16_t* steps, int width, float to_whole, std::uint32_t* row) {
    constexpr float to_integer = 0x1.8p23f;
    for (int x = 0; x < width; ++x)
        row[x] =
            std::bit_cast<std::uint32_t>(static_cast<float>(steps[x]) * to_whole + to_integer) -
            std::bit_cast<std::uint32_t>(to_integer);
}

/// Integers of one row. Returns whether every sample will decode within `error`.
bool quantise_row(const float* samples, int width, float step, float error, std::uint32_t* row) {
    const auto step_d = static_cast<double>(step);
    const auto error_d = static_cast<double>(error);
    const double per_step = 1.0 / step_d;
    // Adding 1.5 * 2^52 rounds to the nearest integer and leaves it in the low bits.
    constexpr double to_integer = 0x1.8p52;
    double worst = 0;
    for (int x = 0; x < width; ++x) {
        const auto value = static_cast<double>(samples[x]);
        const double shifted = value * per_step + to_integer;
        row[x] = static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(shifted));
        const auto decoded = static_cast<float>((shifted - to_integer) * step_d);
        const double miss = std::abs(static_cast<double>(decoded) - value);
        worst = miss > worst ? miss : worst;
    }
    return worst <= error_d;
}

/// Residuals of all rows of integers; `fill(y, row)` says each row, or that it cannot. Returns the OR of them, or nothing.
template <class Fill>
std::optional<std::uint32_t> residuals_of(TileShape shape, const Fill& fill) {
    Scratch& memory = scratch();
    const auto width = static_cast<std::size_t>(shape.width);
    const auto height = static_cast<std::size_t>(shape.height);
    memory.residuals.resize(width * height);
    memory.row.assign(width + 1, 0); // column -1 is zero
    memory.row_above.assign(width + 1, 0);
    std::uint32_t all = 0;
    for (std::size_t y = 0; y < height; ++y) {
        std::uint32_t* row = memory.row.data() + 1;
        const std::uint32_t* above = memory.row_above.data() + 1;
        if (!fill(y, row))
            return std::nullopt;
        std::uint32_t* residuals = memory.residuals.data() + y * width;
        for (std::size_t x = 0; x < width; ++x) {
            const std::uint32_t left = (row - 1)[x] - (above - 1)[x];
            residuals[x] = zigzag(row[x] - above[x] - left);
            all |= residuals[x];
        }
        std::swap(memory.row, memory.row_above);
    }
    return all;
}

/// The same of samples, or nothing if the bound cannot be kept. A step of 0: lossless.
std::optional<std::uint32_t> predict(std::span<const float> samples, TileShape shape,
                                     std::size_t row_stride, float step, float error) {
    return residuals_of(shape, [&](std::size_t y, std::uint32_t* row) {
        const float* source = samples.data() + y * row_stride;
        if (step > 0)
            return quantise_row(source, shape.width, step, error, row);
        for (int x = 0; x < shape.width; ++x)
            row[x] = ordered_bits(source[x]);
        return true;
    });
}

int planes_of(std::uint32_t all_residuals) {
    return std::max(1, (static_cast<int>(std::bit_width(all_residuals)) + 7) / 8);
}

std::vector<std::uint8_t> finish(Mode mode, TileShape shape, int planes, float parameter,
                                 std::span<const std::uint8_t> body) {
    std::vector<std::uint8_t> bytes(header_bytes + body.size());
    bytes[0] = codec_version;
    bytes[1] = static_cast<std::uint8_t>(mode);
    put(&bytes[2], static_cast<std::uint16_t>(shape.width));
    put(&bytes[4], static_cast<std::uint16_t>(shape.height));
    bytes[6] = static_cast<std::uint8_t>(planes);
    put(&bytes[8], parameter);
    if (!body.empty())
        std::memcpy(bytes.data() + header_bytes, body.data(), body.size());
    put(&bytes[checksum_at], tile_checksum(bytes));
    return bytes;
}

/// Bytes of the residuals: byte planes, or `halves`.
void lay_out(int planes) {
    Scratch& memory = scratch();
    const std::size_t count = memory.residuals.size();
    if (planes == halves) {
        memory.residuals.push_back(0); // the other half of the last one of an odd number
        memory.planes.resize((count + 1) / 2);
        for (std::size_t i = 0; i < memory.planes.size(); ++i)
            memory.planes[i] = static_cast<std::uint8_t>(memory.residuals[2 * i] |
                                                         memory.residuals[2 * i + 1] << 4);
        return;
    }
    memory.planes.resize(count * static_cast<std::size_t>(planes));
    for (int plane = 0; plane < planes; ++plane) {
        std::uint8_t* out = memory.planes.data() + count * static_cast<std::size_t>(plane);
        const int shift = 8 * plane;
        for (std::size_t i = 0; i < count; ++i)
            out[i] = static_cast<std::uint8_t>(memory.residuals[i] >> shift);
    }
}

/// Of the residuals; `first`: bytes that go before them as they are.
Result<std::vector<std::uint8_t>> compress(Mode mode, TileShape shape, int planes, float parameter,
                                           std::span<const std::uint8_t> first = {}) {
    Scratch& memory = scratch();
    lay_out(planes);
    memory.compressed.resize(first.size() + ZSTD_compressBound(memory.planes.size()));
    std::copy(first.begin(), first.end(), memory.compressed.begin());
    const std::size_t written = unless_no_memory(ZSTD_compressCCtx(
        made(memory.encoder, ZSTD_createCCtx), memory.compressed.data() + first.size(),
        memory.compressed.size() - first.size(), memory.planes.data(), memory.planes.size(),
        zstd_level));
    if (ZSTD_isError(written))
        return Error{fmt::format("zstd: {}", ZSTD_getErrorName(written))};
    return finish(mode, shape, planes, parameter,
                  std::span(memory.compressed).first(first.size() + written));
}

/// Differences of samples to what is expected, zigzag, into the residuals, and what they come to, into the lattice too. Returns the OR of them,
/// or nothing where the bound cannot be kept or what is expected is of no use.
std::optional<std::uint32_t> differ(std::span<const float> samples, TileShape shape,
                                    std::size_t row_stride, float fine, float error,
                                    std::span<const float> expected, std::span<float> decoded) {
    Scratch& memory = scratch();
    const auto fine_d = static_cast<double>(fine), error_d = static_cast<double>(error);
    const double step_d = fine_steps * fine_d, most = lattice_max * fine_d;
    const std::size_t count =
        static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height);
    memory.residuals.resize(count);
    memory.lattice.resize(count);
    std::uint32_t* residual = memory.residuals.data();
    std::int32_t* point = memory.lattice.data();
    std::uint32_t all = 0;
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
            const std::size_t at =
                static_cast<std::size_t>(y) * row_stride + static_cast<std::size_t>(x);
            const auto value = static_cast<double>(samples[at]);
            const auto guess = static_cast<double>(expected[at]);
            if (!(std::abs(guess) < most))
                return std::nullopt;
            const std::int32_t guessed = nearest_step(guess, fine_d);
            const std::int32_t steps = nearest_step(value - guessed * fine_d, step_d);
            *point = guessed + fine_steps * steps;
            decoded[at] = static_cast<float>(*point++ * fine_d);
            if (!(std::abs(static_cast<double>(decoded[at]) - value) <= error_d))
                return std::nullopt;
            *residual = zigzag(static_cast<std::uint32_t>(steps));
            all |= *residual++;
        }
    return all;
}

/// What differ() made, by its points of the lattice and not by their floats, of which one may stand for several.
Result<std::vector<std::uint8_t>> encode_lattice(TileShape shape, float step) {
    const auto width = static_cast<std::size_t>(shape.width);
    const auto all = residuals_of(shape, [&](std::size_t y, std::uint32_t* row) {
        const std::int32_t* points = scratch().lattice.data() + y * width;
        for (std::size_t x = 0; x < width; ++x)
            row[x] = static_cast<std::uint32_t>(points[x]);
        return true;
    });
    return compress(Mode::quantised, shape, planes_of(*all), step);
}

std::array<std::uint8_t, samples_check_bytes> check_of(std::span<const float> samples,
                                                       TileShape shape, std::size_t row_stride) {
    std::array<std::uint8_t, samples_check_bytes> bytes;
    put(bytes.data(), samples_checksum(samples, shape, row_stride));
    return bytes;
}

} // namespace

Result<std::vector<std::uint8_t>> encode_tile(std::span<const float> samples, TileShape shape,
                                              std::size_t row_stride, float error) {
    SEAWAY_TRY(check_call(samples.size(), shape, row_stride));
    if (!(error >= 0) || !std::isfinite(error))
        return Error{fmt::format("tile error bound is {}, must be finite and >= 0", error)};
    const Survey seen = survey(samples, shape, row_stride);
    if (!seen.finite)
        return Error{"tile holds a sample that is not finite"};
    if (seen.constant)
        return finish(Mode::constant, shape, 0, samples[0], {});
    if (const float step = choose_step(seen.magnitude_max, error); step > 0) {
        const auto all = predict(samples, shape, row_stride, step, error);
        const std::uint32_t first = all ? unzigzag(scratch().residuals[0]) : 0;
        // Only the corner differs from zero: every sample decodes to the same value.
        if (all && std::all_of(scratch().residuals.begin() + 1, scratch().residuals.end(),
                               [](std::uint32_t residual) { return residual == 0; }))
            return finish(Mode::constant, shape, 0,
                          static_cast<float>(static_cast<double>(static_cast<std::int32_t>(first)) *
                                             static_cast<double>(step)),
                          {});
        if (all)
            return compress(Mode::quantised, shape, planes_of(*all), step);
    }
    const auto all = predict(samples, shape, row_stride, 0, 0);
    return compress(Mode::lossless, shape, planes_of(*all), 0);
}

Result<std::vector<std::uint8_t>> encode_tile_steps(std::span<const std::int16_t> steps,
                                                    TileShape shape, std::size_t row_stride,
                                                    float step, float error) {
    SEAWAY_TRY(check_call(steps.size(), shape, row_stride));
    if (!(error >= 0) || !std::isfinite(error))
        return Error{fmt::format("tile error bound is {}, must be finite and >= 0", error)};
    if (!(step >= std::numeric_limits<float>::min()) || step > step_max / 0x1p12f)
        return Error{fmt::format("step of samples is {}, must be {} .. {}", step,
                                 std::numeric_limits<float>::min(), step_max / 0x1p12f)};
    const StepSurvey seen = survey(steps, shape, row_stride);
    if (seen.constant)
        return finish(Mode::constant, shape, 0, static_cast<float>(steps[0]) * step, {});
    const int factor = factor_within(seen.magnitude_max, step, error);
    const float to_whole = 1.0f / static_cast<float>(factor);
    const auto all = residuals_of(shape, [&](std::size_t y, std::uint32_t* row) {
        multiples_row(steps.data() + y * row_stride, shape.width, to_whole, row);
        return true;
    });
    const float coded = static_cast<float>(factor) * step;
    const std::uint32_t first = unzigzag(scratch().residuals[0]);
    if (std::all_of(scratch().residuals.begin() + 1, scratch().residuals.end(),
                    [](std::uint32_t residual) { return residual == 0; }))
        return finish(Mode::constant, shape, 0,
                      static_cast<float>(static_cast<std::int32_t>(first)) * coded, {});
    return compress(Mode::quantised, shape, planes_of(*all), coded);
}

Result<TileForms> encode_tile_forms(std::span<const float> samples, TileShape shape,
                                    std::size_t row_stride, float error,
                                    std::span<const float> expected, std::span<float> decoded) {
    SEAWAY_TRY(check_call(samples.size(), shape, row_stride));
    SEAWAY_TRY(check_call(expected.size(), shape, row_stride));
    SEAWAY_TRY(check_call(decoded.size(), shape, row_stride));
    const auto alone = [&]() -> Result<TileForms> {
        TileForms forms;
        SEAWAY_TRY_LET(forms.whole, encode_tile(samples, shape, row_stride, error));
        SEAWAY_TRY(decode_tile(forms.whole, shape, row_stride, decoded));
        return forms;
    };
    const Survey seen = survey(samples, shape, row_stride);
    if (!seen.finite || seen.constant || !(error >= 0) || !std::isfinite(error))
        return alone();
    const float fine = choose_step(seen.magnitude_max, error) / fine_steps;
    if (!(fine >= std::numeric_limits<float>::min()) ||
        static_cast<double>(seen.magnitude_max) >= 0.5 * lattice_max * static_cast<double>(fine))
        return alone();
    const auto all = differ(samples, shape, row_stride, fine, error, expected, decoded);
    if (!all)
        return alone();
    TileForms forms;
    const auto check = check_of(decoded, shape, row_stride);
    SEAWAY_TRY_LET(forms.difference,
                   compress(Mode::difference, shape, *all <= half_max ? halves : planes_of(*all),
                            fine, check));
    SEAWAY_TRY_LET(forms.whole, encode_lattice(shape, fine));
    return forms;
}

} // namespace seaway::protocol
