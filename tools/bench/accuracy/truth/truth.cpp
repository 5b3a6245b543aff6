// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/truth/truth.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "base/worse.h"
#include "protocol/checksum.h"
#include "sea/surface/inverse.h"
#include "sea/waves/reference.h"
#include "tools/bench/accuracy/truth/in_threads.h"

namespace seaway::bench {

namespace {

/// To be counted up when points or sums are made in another way.
constexpr std::uint32_t truth_version = 3;
constexpr int checked_points = 4;

template <class T>
std::span<const std::uint8_t> bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)};
}

/// Of all that the surface of a sea follows from, and the version.
std::uint32_t checksum(const sea::Realization& sea) {
    static_assert(sizeof(sea::SineField::Wave) == 7 * sizeof(double), "no byte that is nothing");
    std::uint32_t sum = truth_version;
    const auto add = [&](const auto& values) { sum = protocol::crc32(bytes_of(values), sum); };
    const auto add_each = [&](auto... numbers) { (add(std::vector{numbers}), ...); };
    add_each(sea.choppiness.x, sea.choppiness.y, sea.loop_period_us);
    for (const sea::CascadeModes& cascade : sea.cascades) {
        add_each(cascade.spec.length_m, cascade.spec.size, cascade.depth_m);
        add(cascade.h0);
        add(cascade.rate);
        add(cascade.phase_offset_turns);
        for (const sea::SineField& field : cascade.sines) {
            add_each(field.kind, field.length_m, field.sharpness, field.drag, field.share);
            add(field.waves);
            for (const sea::NoiseOctave& octave : field.octaves) {
                add_each(octave.cells, octave.amplitude_m, octave.speed_x_mps, octave.speed_y_mps,
                         octave.rate_x, octave.rate_y, octave.offset_x, octave.offset_y);
                add(*octave.corners);
            }
        }
    }
    return sum;
}

/// Of the sea, the points and the version.
std::string file_name(const Waves& waves, const Sampling& sampling, std::uint64_t seed) {
    const std::string shared =
        sampling.first_time == 0 && sampling.time_step == 1
            ? std::string()
            : fmt::format("_{}of{}", sampling.first_time, sampling.time_step);
    return fmt::format("truth_{:08x}_{}_{}_{}{}{}.bin", checksum(*waves.all), sampling.points,
                       sampling.times, seed, shared, sampling.film ? "" : "_still");
}

struct Header {
    char magic[8] = {'s', 'e', 'a', 't', 'r', 'u', 't', 'h'};
    std::uint64_t points = 0;
    double sum_error_m = 0;
    sea::TimeUs movie_start_us = 0;
};

template <class T>
void put(std::ofstream& file, const std::vector<T>& values) {
    const auto bytes = bytes_of(values);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
}

template <class T>
void get(std::ifstream& file, std::vector<T>& values, std::size_t count) {
    values.resize(count);
    file.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(count * sizeof(T)));
}

std::optional<Truth> read(const std::string& path, bool film) {
    std::ifstream file(path, std::ios::binary);
    Header header;
    const Header wanted;
    file.read(reinterpret_cast<char*>(&header), sizeof header);
    if (!file || std::memcmp(header.magic, wanted.magic, sizeof wanted.magic) != 0)
        return std::nullopt;
    Truth truth;
    truth.sum_error_m = header.sum_error_m;
    truth.movie.start_us = header.movie_start_us;
    get(file, truth.points, header.points);
    get(file, truth.answers, header.points);
    if (film) {
        get(file, truth.movie.at, Movie::points);
        get(file, truth.movie.heights_m, static_cast<std::size_t>(Movie::points) * Movie::frames);
    }
    return file ? std::optional(std::move(truth)) : std::nullopt;
}

/// Under another name first: a run that is stopped here leaves no half of a file.
Result<void> write(const std::string& path, const Truth& truth) {
    {
        std::ofstream file(path + ".part", std::ios::binary);
        const Header header{.points = truth.points.size(),
                            .sum_error_m = truth.sum_error_m,
                            .movie_start_us = truth.movie.start_us};
        file.write(reinterpret_cast<const char*>(&header), sizeof header);
        put(file, truth.points);
        put(file, truth.answers);
        put(file, truth.movie.at);
        put(file, truth.movie.heights_m);
        if (!file.flush())
            return Error{"cannot write " + path + ".part"};
    }
    std::error_code failed;
    std::filesystem::rename(path + ".part", path, failed);
    return failed ? Result<void>(Error{"cannot write " + path}) : Result<void>();
}

void solve(const sea::DirectSum& sum, const sea::InverseOptions& options, Truth& truth) {
    // Some 5 ms and more each, of which a new moment is 0.05: threads end together.
    constexpr std::size_t points_a_part = 128;
    const std::size_t count = truth.points.size();
    truth.answers.resize(count);
    in_parts(count, points_a_part, [&](std::size_t begin, std::size_t end) {
        std::optional<sea::DirectSum::Moment> now;
        for (std::size_t i = begin; i < end; ++i) {
            const sea::QueryPoint& at = truth.points[i].at;
            if (i == begin || at.time_us != truth.points[i - 1].at.time_us)
                now = sum.at_time(at.time_us);
            truth.answers[i] = sea::surface_at(at, options, *now);
        }
    });
}

void film(const sea::DirectSum& sum, const sea::InverseOptions& options, Movie& movie) {
    movie.heights_m.resize(static_cast<std::size_t>(Movie::points) * Movie::frames);
    in_threads(Movie::frames, [&](int frame) {
        const sea::DirectSum::Moment now = sum.at_time(movie.time_us(frame));
        for (std::size_t p = 0; p < Movie::points; ++p) {
            sea::QueryPoint at = movie.at[p];
            at.time_us = movie.time_us(frame);
            movie.heights_m[p * Movie::frames + static_cast<std::size_t>(frame)] =
                sea::surface_at(at, options, now).height_m;
        }
    });
}

double largest_difference(const sea::DirectSum& sum, const Truth& truth) {
    double largest = 0;
    const std::size_t stride = std::max<std::size_t>(truth.points.size() / checked_points, 1);
    for (std::size_t i = 0; i < truth.points.size(); i += stride) {
        const sea::QueryPoint& at = truth.points[i].at;
        const double here = sum.at(at.x_m, at.y_m, at.time_us).height;
        largest = worse(
            largest, std::abs(here - height_in_long_double(sum.sea(), at.x_m, at.y_m, at.time_us)));
    }
    return largest;
}

} // namespace

sea::TimeUs Movie::time_us(int frame) const {
    return start_us + std::llround(frame * sea::microseconds_per_second / frames_per_s);
}

double height_in_long_double(const sea::Realization& sea, double x_m, double y_m,
                             sea::TimeUs time_us) {
    using Real = long double;
    constexpr Real turn = 2 * std::numbers::pi_v<Real>;
    const sea::TimeUs t = sea.phase_time(time_us);
    Real sum = 0;
    for (const sea::CascadeModes& cascade : sea.cascades) {
        const int size = cascade.spec.size;
        const Real x = x_m / static_cast<Real>(cascade.spec.length_m);
        const Real y = y_m / static_cast<Real>(cascade.spec.length_m);
        for_each_wave(cascade, [&](std::size_t i, double, double, double, double) {
            const int nx = sea::signed_index(static_cast<int>(i) % size, size);
            const int ny = sea::signed_index(static_cast<int>(i) / size, size);
            const Real turns = nx * x + ny * y -
                               static_cast<Real>(sea::phase_turns(cascade.rate[i], t)) * 0x1p-64L;
            const Real angle = turn * (turns - std::floor(turns));
            // This wave and its conjugate at -k: twice the real part.
            sum += 2 * (cascade.h0[i].real() * std::cos(angle) -
                        cascade.h0[i].imag() * std::sin(angle));
        });
    }
    return static_cast<double>(sum);
}

Truth summed_truth(const Waves& waves, const Sampling& sampling, std::uint64_t seed) {
    const sea::DirectSum sum(waves.all);
    const sea::InverseOptions options{waves.all->choppiness, truth_tolerance_m,
                                      sea::fold_search(waves.budget)};
    Truth truth;
    truth.points = sample_points(waves.all, sampling, seed);
    truth.movie.start_us = sample_time_us(1);
    for (std::size_t p = 0; sampling.film && p < Movie::points; ++p)
        truth.movie.at.push_back(truth.points[p % truth.points.size()].at);
    solve(sum, options, truth);
    if (sampling.film)
        film(sum, options, truth.movie);
    truth.sum_error_m = largest_difference(sum, truth);
    return truth;
}

Result<Truth> reference_truth(const Waves& waves, const Sampling& sampling, std::uint64_t seed,
                              const std::string& folder) {
    const std::string path = folder + "/" + file_name(waves, sampling, seed);
    if (std::optional<Truth> kept = read(path, sampling.film))
        return *std::move(kept);
    Truth truth = summed_truth(waves, sampling, seed);
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    SEAWAY_TRY(write(path, truth));
    return truth;
}

} // namespace seaway::bench
