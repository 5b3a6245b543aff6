// SPDX-License-Identifier: Apache-2.0
// Decoder of tile codec v1 (protocol/tile_codec.h), and the check that both sides make.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "protocol/checksum.h"
#include "protocol/limits.h"
#include "protocol/tile_layout.h"
#include "protocol/zstd_memory.h"

namespace seaway::protocol {

Result<void> tile_layout::check_call(std::size_t samples, TileShape shape, std::size_t row_stride) {
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

std::uint32_t tile_layout::samples_checksum(std::span<const float> samples, TileShape shape,
                                            std::size_t row_stride) {
    std::uint32_t crc = 0;
    for (int y = 0; y < shape.height; ++y)
        crc = crc32({reinterpret_cast<const std::uint8_t*>(
                         samples.data() + static_cast<std::size_t>(y) * row_stride),
                     static_cast<std::size_t>(shape.width) * sizeof(float)},
                    crc);
    return crc;
}

namespace {

using namespace tile_layout;

/// Working memory of one thread, at most 0.5 MB: taken once.
struct Scratch {
    std::vector<std::uint8_t> planes;
    std::vector<std::uint32_t> column_sums; ///< vertical sums of residuals
    std::vector<std::uint32_t> row;
    ZstdDecoder decoder;
};

Scratch& scratch() {
    thread_local Scratch memory;
    return memory;
}

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
    if (bytes[1] > static_cast<std::uint8_t>(Mode::difference) || bytes[7] != 0)
        return Error{fmt::format("tile mode {}, 0 to 3 are known", bytes[1])};
    const bool constant = header.mode == Mode::constant;
    const int planes_min = header.mode == Mode::difference ? halves : 1;
    if (constant ? header.planes != 0 || bytes.size() != header_bytes
                 : header.planes < planes_min || header.planes > 4)
        return Error{fmt::format("tile of mode {} with {} byte planes", bytes[1], bytes[6])};
    const bool parameter_fine =
        header.mode == Mode::quantised || header.mode == Mode::difference
            ? header.parameter > 0 && header.parameter <= step_max
            : (constant ? std::isfinite(header.parameter) : header.parameter == 0);
    if (!parameter_fine)
        return Error{fmt::format("tile parameter {} out of range", header.parameter)};
    return header;
}

Result<void> decompress(std::span<const std::uint8_t> body, std::size_t count) {
    Scratch& memory = scratch();
    memory.planes.resize(count);
    const std::size_t read = unless_no_memory(
        ZSTD_decompressDCtx(made(memory.decoder, ZSTD_createDCtx), memory.planes.data(),
                            memory.planes.size(), body.data(), body.size()));
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

/// Number n of a difference.
std::uint32_t code_at(const std::vector<std::uint8_t>& bytes, int planes, std::size_t count,
                      std::size_t n) {
    if (planes == halves)
        return (bytes[n / 2] >> (4 * (n % 2))) & half_max;
    std::uint32_t code = 0;
    for (int plane = 0; plane < planes; ++plane)
        code |= static_cast<std::uint32_t>(bytes[static_cast<std::size_t>(plane) * count + n])
                << (8 * plane);
    return code;
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

Result<void> decode_tile(std::span<const std::uint8_t> bytes, TileShape shape,
                         std::size_t row_stride, std::span<float> samples) {
    SEAWAY_TRY(check_call(samples.size(), shape, row_stride));
    const Result<Header> header = read_header(bytes, shape);
    if (!header)
        return header.error();
    if (header->mode == Mode::difference)
        return Error{"tile is the difference to another, which is not there"};
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
    memory.column_sums.assign(width, 0);
    memory.row.resize(width);
    bool finite = true;
    for (std::size_t y = 0; y < height; ++y) {
        add_row(memory.planes.data() + y * width, plane_bytes, header->planes, width,
                memory.column_sums.data());
        std::uint32_t sum = 0;
        for (std::size_t x = 0; x < width; ++x) {
            sum += memory.column_sums[x];
            memory.row[x] = sum;
        }
        finite &= write_row(memory.row.data(), width, *header, samples.data() + y * row_stride);
    }
    return finite ? Result<void>() : Error{"tile holds a sample that is not finite"};
}

bool is_difference(std::span<const std::uint8_t> bytes) {
    return bytes.size() >= header_bytes && bytes[1] == static_cast<std::uint8_t>(Mode::difference);
}

Result<void> decode_tile_difference(std::span<const std::uint8_t> bytes, TileShape shape,
                                    std::size_t row_stride, std::span<const float> expected,
                                    std::span<float> samples) {
    SEAWAY_TRY(check_call(samples.size(), shape, row_stride));
    SEAWAY_TRY(check_call(expected.size(), shape, row_stride));
    SEAWAY_TRY_LET(const Header header, read_header(bytes, shape));
    if (header.mode != Mode::difference)
        return Error{"tile is no difference"};
    if (bytes.size() < header_bytes + samples_check_bytes)
        return Error{fmt::format("tile of {} bytes is no difference", bytes.size())};
    const auto width = static_cast<std::size_t>(shape.width);
    const std::size_t count = width * static_cast<std::size_t>(shape.height);
    SEAWAY_TRY(decompress(bytes.subspan(header_bytes + samples_check_bytes),
                          header.planes == halves
                              ? (count + 1) / 2
                              : count * static_cast<std::size_t>(header.planes)));
    const auto fine = static_cast<double>(header.parameter);
    std::size_t n = 0;
    for (std::size_t y = 0; y < static_cast<std::size_t>(shape.height); ++y)
        for (std::size_t at = y * row_stride; at < y * row_stride + width; ++at) {
            const auto guess = static_cast<double>(expected[at]);
            const std::uint32_t code = code_at(scratch().planes, header.planes, count, n++);
            const double lattice =
                static_cast<double>(nearest_step(guess, fine)) +
                fine_steps * static_cast<double>(static_cast<std::int32_t>(unzigzag(code)));
            if (!(std::abs(guess) < lattice_max * fine) || !(std::abs(lattice) < quantum_max))
                return Error{TileMiss::other_expected,
                             "tile is the difference to a sample that is out of its range"};
            samples[at] = static_cast<float>(lattice * fine);
        }
    if (get<std::uint32_t>(&bytes[header_bytes]) != samples_checksum(samples, shape, row_stride))
        return Error{TileMiss::other_expected,
                     "tile does not come to the samples that were encoded"};
    return {};
}

} // namespace seaway::protocol
