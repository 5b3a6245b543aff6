// SPDX-License-Identifier: Apache-2.0
#include "protocol/tile_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <zstd.h>

#include "protocol/checksum.h"
#include "protocol/limits.h"

namespace seaway::protocol {
namespace {

// Layout, little endian (docs/protocol.md): version, mode, width, height, planes, 0, parameter,
// checksum, zstd frame.
constexpr std::uint8_t codec_version = 1;
constexpr std::size_t header_bytes = 16;
constexpr std::size_t checksum_at = 12;
constexpr int zstd_level = 3;
/// Largest |q|: q * step is exact in a double (30 + 24 bits) and every int32 sum of two fits.
constexpr double quantum_max = 0x1p30;
/// Largest step: 2^31 of them are still a float.
constexpr float step_max = 0x1p96f;

enum class Mode : std::uint8_t {
    constant = 0,  ///< parameter is the value of every sample
    quantised = 1, ///< parameter is the step; integers q, sample = float(q * step)
    lossless = 2,  ///< parameter is 0; integers are the floats' bits, in numerical order
};

static_assert(std::endian::native == std::endian::little, "the wire is little endian");

template <class T>
void put(std::uint8_t* at, T value) {
    std::memcpy(at, &value, sizeof value);
}

template <class T>
T get(const std::uint8_t* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

struct FreeContext {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// Working memory of one thread, at most 1.5 MB: taken once, so that the steady state allocates
/// only the bytes that it returns.
struct Scratch {
    std::vector<std::uint32_t> residuals;
    std::vector<std::uint32_t> row;
    std::vector<std::uint32_t> row_above;
    std::vector<std::uint8_t> planes;
    std::vector<std::uint8_t> compressed;
    std::unique_ptr<ZSTD_CCtx, FreeContext> encoder;
    std::unique_ptr<ZSTD_DCtx, FreeContext> decoder;
};

Scratch& scratch() {
    thread_local Scratch memory;
    return memory;
}

Result<void> check_call(std::size_t samples, TileShape shape, std::size_t row_stride) {
    const auto valid = [](int side) { return side >= 1 && side <= limits::tile_side_max; };
    if (!valid(shape.width) || !valid(shape.height))
        return Error{fmt::format("tile of {} x {} samples, sides of 1 to {} are allowed",
                                 shape.width, shape.height, limits::tile_side_max)};
    const auto width = static_cast<std::size_t>(shape.width);
    const auto height = static_cast<std::size_t>(shape.height);
    if (row_stride < width || samples < (height - 1) * row_stride + width)
        return Error{fmt::format("{} samples with row stride {} hold no tile of {} x {}", samples,
                                 row_stride, width, height)};
    return {};
}

std::uint32_t zigzag(std::uint32_t residual) {
    return (residual << 1) ^ (0u - (residual >> 31));
}

std::uint32_t unzigzag(std::uint32_t code) {
    return (code >> 1) ^ (0u - (code & 1u));
}

/// Float bits as integers in numerical order, and back.
std::uint32_t ordered_bits(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits ^ ((0u - (bits >> 31)) >> 1);
}

std::uint32_t unordered_bits(std::uint32_t ordered) {
    return ordered ^ ((0u - (ordered >> 31)) >> 1);
}

// ---- encoder -------------------------------------------------------------------------------

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

/// Residuals of all rows. Returns the OR of them, or nothing if the bound cannot be kept.
std::optional<std::uint32_t> predict(std::span<const float> samples, TileShape shape,
                                     std::size_t row_stride, float step, float error) {
    Scratch& memory = scratch();
    const auto width = static_cast<std::size_t>(shape.width);
    const auto height = static_cast<std::size_t>(shape.height);
    memory.residuals.resize(width * height);
    memory.row.assign(width + 1, 0); // column -1 is zero
    memory.row_above.assign(width + 1, 0);
    std::uint32_t all = 0;
    for (std::size_t y = 0; y < height; ++y) {
        const float* source = samples.data() + y * row_stride;
        std::uint32_t* row = memory.row.data() + 1;
        const std::uint32_t* above = memory.row_above.data() + 1;
        if (step > 0) {
            if (!quantise_row(source, shape.width, step, error, row))
                return std::nullopt;
        } else {
            for (std::size_t x = 0; x < width; ++x)
                row[x] = ordered_bits(source[x]);
        }
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

Result<std::vector<std::uint8_t>> compress(Mode mode, TileShape shape, std::uint32_t all,
                                           float parameter) {
    Scratch& memory = scratch();
    const std::size_t count = memory.residuals.size();
    const int planes = planes_of(all);
    memory.planes.resize(count * static_cast<std::size_t>(planes));
    for (int plane = 0; plane < planes; ++plane) {
        std::uint8_t* out = memory.planes.data() + count * static_cast<std::size_t>(plane);
        const int shift = 8 * plane;
        for (std::size_t i = 0; i < count; ++i)
            out[i] = static_cast<std::uint8_t>(memory.residuals[i] >> shift);
    }
    if (memory.encoder == nullptr)
        memory.encoder.reset(ZSTD_createCCtx());
    memory.compressed.resize(ZSTD_compressBound(memory.planes.size()));
    const std::size_t written =
        ZSTD_compressCCtx(memory.encoder.get(), memory.compressed.data(), memory.compressed.size(),
                          memory.planes.data(), memory.planes.size(), zstd_level);
    if (ZSTD_isError(written))
        return Error{fmt::format("zstd: {}", ZSTD_getErrorName(written))};
    return finish(mode, shape, planes, parameter, std::span(memory.compressed).first(written));
}

// ---- decoder -------------------------------------------------------------------------------

struct Header {
    Mode mode;
    int planes;
    float parameter;
};

Result<Header> read_header(std::span<const std::uint8_t> bytes, TileShape shape) {
    if (bytes.size() < header_bytes)
        return Error{
            fmt::format("tile of {} bytes, at least {} are needed", bytes.size(), header_bytes)};
    if (get<std::uint32_t>(&bytes[checksum_at]) != tile_checksum(bytes))
        return Error{"tile checksum does not match"};
    if (bytes[0] != codec_version)
        return Error{fmt::format("tile codec version {}, {} is known", bytes[0], codec_version)};
    if (get<std::uint16_t>(&bytes[2]) != shape.width ||
        get<std::uint16_t>(&bytes[4]) != shape.height)
        return Error{fmt::format("tile of {} x {} samples, {} x {} expected",
                                 get<std::uint16_t>(&bytes[2]), get<std::uint16_t>(&bytes[4]),
                                 shape.width, shape.height)};
    const Header header{.mode = static_cast<Mode>(bytes[1]),
                        .planes = bytes[6],
                        .parameter = get<float>(&bytes[8])};
    if (bytes[1] > static_cast<std::uint8_t>(Mode::lossless) || bytes[7] != 0)
        return Error{fmt::format("tile mode {}, 0 to 2 are known", bytes[1])};
    const bool constant = header.mode == Mode::constant;
    if (constant ? header.planes != 0 || bytes.size() != header_bytes
                 : header.planes < 1 || header.planes > 4)
        return Error{fmt::format("tile of mode {} with {} byte planes", bytes[1], bytes[6])};
    const bool parameter_fine =
        header.mode == Mode::quantised
            ? header.parameter > 0 && header.parameter <= step_max
            : (constant ? std::isfinite(header.parameter) : header.parameter == 0);
    if (!parameter_fine)
        return Error{fmt::format("tile parameter {} out of range", header.parameter)};
    return header;
}

Result<void> decompress(std::span<const std::uint8_t> body, std::size_t count) {
    Scratch& memory = scratch();
    if (memory.decoder == nullptr)
        memory.decoder.reset(ZSTD_createDCtx());
    memory.planes.resize(count);
    const std::size_t read = ZSTD_decompressDCtx(memory.decoder.get(), memory.planes.data(),
                                                 memory.planes.size(), body.data(), body.size());
    if (ZSTD_isError(read))
        return Error{fmt::format("tile does not decompress: {}", ZSTD_getErrorName(read))};
    if (read != count)
        return Error{fmt::format("tile holds {} bytes, {} expected", read, count)};
    return {};
}

/// Joins byte planes of row y and adds the residuals onto the running vertical sums.
void add_row(const std::uint8_t* planes, std::size_t plane_bytes, int plane_count,
             std::size_t width, std::uint32_t* sums) {
    if (plane_count == 1) { // the common case, worth its own loop: half the decoder's time
        for (std::size_t x = 0; x < width; ++x)
            sums[x] += unzigzag(planes[x]);
    } else if (plane_count == 2) {
        const std::uint8_t* high = planes + plane_bytes;
        for (std::size_t x = 0; x < width; ++x)
            sums[x] += unzigzag(planes[x] | static_cast<std::uint32_t>(high[x]) << 8);
    } else {
        for (std::size_t x = 0; x < width; ++x) {
            std::uint32_t code = 0;
            for (int plane = 0; plane < plane_count; ++plane)
                code |= static_cast<std::uint32_t>(
                            planes[static_cast<std::size_t>(plane) * plane_bytes + x])
                        << (8 * plane);
            sums[x] += unzigzag(code);
        }
    }
}

/// One row of integers to floats; false if a float is not finite.
bool write_row(const std::uint32_t* row, std::size_t width, const Header& header, float* out) {
    if (header.mode == Mode::quantised) {
        const auto step = static_cast<double>(header.parameter);
        for (std::size_t x = 0; x < width; ++x)
            out[x] =
                static_cast<float>(static_cast<double>(static_cast<std::int32_t>(row[x])) * step);
        return true; // |q| * step <= 2^31 * 2^96
    }
    std::uint32_t magnitude_max = 0;
    for (std::size_t x = 0; x < width; ++x) {
        const std::uint32_t bits = unordered_bits(row[x]);
        out[x] = std::bit_cast<float>(bits);
        magnitude_max = std::max(magnitude_max, bits & 0x7fffffffu);
    }
    return magnitude_max < 0x7f800000u;
}

} // namespace

Result<std::vector<std::uint8_t>> encode_tile(std::span<const float> samples, TileShape shape,
                                              std::size_t row_stride, float error) {
    if (Result<void> fine = check_call(samples.size(), shape, row_stride); !fine)
        return fine.error();
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
            return compress(Mode::quantised, shape, *all, step);
    }
    return compress(Mode::lossless, shape, *predict(samples, shape, row_stride, 0, 0), 0);
}

Result<void> decode_tile(std::span<const std::uint8_t> bytes, TileShape shape,
                         std::size_t row_stride, std::span<float> samples) {
    if (Result<void> fine = check_call(samples.size(), shape, row_stride); !fine)
        return fine;
    const Result<Header> header = read_header(bytes, shape);
    if (!header)
        return header.error();
    const auto width = static_cast<std::size_t>(shape.width);
    const auto height = static_cast<std::size_t>(shape.height);
    if (header->mode == Mode::constant) {
        for (std::size_t y = 0; y < height; ++y)
            std::fill_n(samples.data() + y * row_stride, width, header->parameter);
        return {};
    }
    const std::size_t plane_bytes = width * height;
    Result<void> fine = decompress(bytes.subspan(header_bytes),
                                   plane_bytes * static_cast<std::size_t>(header->planes));
    if (!fine)
        return fine;
    Scratch& memory = scratch();
    memory.row_above.assign(width, 0); // vertical sums of residuals
    memory.row.resize(width);
    bool finite = true;
    for (std::size_t y = 0; y < height; ++y) {
        add_row(memory.planes.data() + y * width, plane_bytes, header->planes, width,
                memory.row_above.data());
        std::uint32_t sum = 0;
        for (std::size_t x = 0; x < width; ++x)
            memory.row[x] = sum += memory.row_above[x];
        finite &= write_row(memory.row.data(), width, *header, samples.data() + y * row_stride);
    }
    return finite ? Result<void>() : Error{"tile holds a sample that is not finite"};
}

} // namespace seaway::protocol
