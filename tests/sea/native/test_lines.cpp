// SPDX-License-Identifier: Apache-2.0
// What is shown between the two passes is what its name says.
#include <algorithm>
#include <cmath>
#include <complex>
#include <set>

#include <gtest/gtest.h>

#include "base/worse.h"
#include "sea/native/native_runner.h"
#include "tests/sea/native/double_sum.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::sea {
namespace {

using Complex = std::complex<double>;

/// "dh/dt/k ky^2": the rate, over k, times a power of ky.
struct Meaning {
    bool rate, over_k;
    int power;

    explicit Meaning(const std::string& name)
        : rate(name.starts_with("dh/dt")), over_k(name.find("/k") != std::string::npos),
          power(name.ends_with(" ky^2") ? 2
                : name.ends_with(" ky") ? 1
                                        : 0) {}
};

TEST(Lines, each_is_the_half_transform_along_y_of_what_its_name_says) {
    constexpr int size = 32, half = size / 2;
    constexpr TimeUs time_us = 3'210'000;
    const CascadeModes modes = random_modes(size, 11, 4);
    const NativeTransform transform = NativeTransform::create(modes, {1.1, 0.6}).value();
    FieldSet fields = linear_fields;
    fields.insert(Field::jacobian);
    std::vector<float> planes(static_cast<std::size_t>(fields.size() * size * size));
    NativeRunner runner(1);
    const std::vector<NativeLines> shown =
        runner.run_and_show({&transform, time_us, fields, planes});
    std::set<std::string> names;
    for (const NativeLines& lines : shown) {
        names.insert(lines.name);
        const Meaning meaning(lines.name);
        ASSERT_EQ(lines.values.size(), static_cast<std::size_t>(size * half));
        double worst = 0, largest = 0;
        for (int y = 0; y < size; ++y)
            for (int nx = 0; nx < half; ++nx) {
                Complex truth = 0;
                for (int ny = -half + 1; ny < half; ++ny) {
                    const double step = modes.spec.wavenumber_step_radpm(), ky = step * ny;
                    const double k = step * std::hypot(nx, ny);
                    const Complex h =
                        amplitude(modes, meaning.rate ? Field::height_rate : Field::height,
                                  static_cast<std::size_t>(nx),
                                  static_cast<std::size_t>((ny + size) % size), time_us);
                    const double over_k = k > 0 ? 1 / (k * std::tanh(k * modes.depth_m)) : 0;
                    truth += h * (meaning.over_k ? over_k : 1.0) * std::pow(ky, meaning.power) *
                             std::polar(1.0, two_pi * ny * y / size);
                }
                const auto value = Complex(lines.values[static_cast<std::size_t>(y * half + nx)]);
                worst = worse(worst, std::abs(value - truth));
                largest = std::max(largest, std::abs(truth));
            }
        EXPECT_GT(largest, 0) << lines.name;
        EXPECT_LT(worst, 1e-5 * largest) << lines.name; // floats, 32 terms
    }
    EXPECT_EQ(names.size(), shown.size()) << "each has a name of its own";
    // Heights, slopes and displacements with their rates, and strains.
    for (const char* name :
         {"h", "h ky", "h/k", "h/k ky", "h/k ky^2", "dh/dt", "dh/dt/k", "dh/dt/k ky"})
        EXPECT_EQ(names.count(name), 1u) << name;
}

} // namespace
} // namespace seaway::sea
