// SPDX-License-Identifier: Apache-2.0
// seaway-inspect --images: the numbers beside the pictures are those of the definition.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wshadow"
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#pragma GCC diagnostic pop

#include "sea/basics/field.h"
#include "sea/scene/scene.h"
#include "tests/support/program.h"
#include "tests/tools/pixels.h"

namespace seaway {
namespace {

using testing::Pixels;
using tests::Output;
using Complex = std::complex<double>;

const std::string scene_text = R"(
[sea]
seed = 5
[[sea.system]]
type = "wind"
wind_speed_10m_mps = 11.0
from_deg = 200
fetch_m = 80e3
[[cascade]]
length_m = 301.0
size = 128
)";
constexpr int size = 128;

/// One EXR of the pictures.
struct ArrayFile {
    int rows = 0;
    int columns = 0;
    std::vector<float> first;  ///< Y, or re
    std::vector<float> second; ///< im, or empty

    explicit ArrayFile(const std::string& path) {
        Imf::InputFile file(path.c_str());
        columns = file.header().dataWindow().max.x + 1;
        rows = file.header().dataWindow().max.y + 1;
        if (file.header().channels().findChannel("Y") != nullptr)
            first = read(file, "Y");
        else {
            first = read(file, "re");
            second = read(file, "im");
        }
    }
    Complex at(int row, int column) const {
        const auto i = static_cast<std::size_t>(row * columns + column);
        return {static_cast<double>(first[i]), static_cast<double>(second[i])};
    }

  private:
    std::vector<float> read(Imf::InputFile& file, const char* channel) const {
        const auto width = static_cast<std::size_t>(columns);
        std::vector<float> values(width * static_cast<std::size_t>(rows));
        Imf::FrameBuffer buffer;
        buffer.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()),
                                          sizeof(float), sizeof(float) * width));
        file.setFrameBuffer(buffer);
        file.readPixels(0, rows - 1);
        return values;
    }
};

/// Once for all tests: Vulkan's kernels are compiled for seconds.
std::string draw(const std::string& device) {
    static std::set<std::string> drawn;
    const std::string out = tests::folder().file("images_" + device);
    if (drawn.insert(device).second) {
        const std::string scene = tests::folder().write("images.toml", scene_text);
        const Output ran = tests::run_program("seaway-inspect", scene + " --time 12.5 --device " +
                                                                    device + " --images " + out);
        EXPECT_EQ(ran.status, 0) << ran.err;
    }
    return out + "/cascade0_";
}

// Pictures have north up, files the south first: who compares the two is told.
TEST(Images, the_files_beside_the_pictures_say_which_line_is_the_north) {
    const std::string stem = draw("native");
    const auto text = [&](const char* name, const char* attribute) {
        const Imf::InputFile file((stem + name + ".exr").c_str());
        const auto* found = file.header().findTypedAttribute<Imf::StringAttribute>(attribute);
        return found != nullptr ? found->value() : "none";
    };
    for (const char* name : {"height", "h"}) {
        EXPECT_EQ(text(name, "seaway.rows"), "south to north");
        EXPECT_EQ(text(name, "seaway.time_us"), "12500000");
        const Imf::InputFile file((stem + name + ".exr").c_str());
        EXPECT_EQ(file.header().typedAttribute<Imf::DoubleAttribute>("seaway.length_m").value(),
                  301.0);
    }
    EXPECT_EQ(text("h0", "seaway.rows"), "south to north");
    EXPECT_EQ(text("h0", "seaway.time_us"), "none") << "it is of no time";
    EXPECT_EQ(text("columns_h", "seaway.rows"), "none") << "as it lies in memory";
}

TEST(Images, h0_is_the_realised_spectrum_and_h_its_sum_of_both_ways_at_the_time) {
    const std::string stem = draw("native");
    const sea::Realization sea =
        sea::realize(sea::parse_scene(scene_text, "images.toml", ".").value()).value();
    const sea::CascadeModes& modes = sea.cascades[0];
    const ArrayFile h0(stem + "h0.exr"), h(stem + "h.exr");
    ASSERT_EQ(h0.rows, size);
    double largest = 0;
    for (const Complex& value : modes.h0)
        largest = std::max(largest, std::abs(value));
    const auto at = [&](int nx, int ny) {
        return modes.h0[static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size)];
    };
    for (int ny = -size / 2 + 1; ny < size / 2; ++ny)
        for (int nx = -size / 2 + 1; nx < size / 2; ++nx) {
            // k = 0 stands in the middle.
            EXPECT_LE(std::abs(h0.at(ny + size / 2, nx + size / 2) - at(nx, ny)), 1e-7 * largest);
            const double omega = sea::omega_from_rate(modes.rate[static_cast<std::size_t>(
                (ny + size) % size * size + (nx + size) % size)]);
            const Complex turn = std::polar(1.0, -omega * 12.5);
            const Complex truth = at(nx, ny) * turn + std::conj(at(-nx, -ny) * turn);
            EXPECT_LE(std::abs(h.at(ny + size / 2, nx + size / 2) - truth), 1e-6 * largest);
        }
}

/// sum over ky of h(k,t) exp(i ky y), the half of the transform that comes first.
Complex along_y(const ArrayFile& h, int y, int nx) {
    Complex sum = 0;
    for (int ny = -size / 2 + 1; ny < size / 2; ++ny)
        sum += h.at(ny + size / 2, nx + size / 2) *
               std::polar(1.0, 2 * 3.14159265358979324 * ny * y / size);
    return sum;
}

TEST(Images, passes_of_both_devices_are_the_transform_along_y) {
    const std::string native = draw("native"), vulkan = draw("llvmpipe");
    const ArrayFile h(native + "h.exr"), columns(native + "columns_h.exr");
    // lavapipe's subgroups of 8 lanes run design T at 128; source 0 holds h itself.
    const ArrayFile source(vulkan + "t8_128_evolve_band_source_0.exr");
    ASSERT_EQ(columns.rows, size);
    ASSERT_EQ(source.rows, size);
    double largest = 0;
    for (int y = 0; y < size; ++y)
        for (int nx = 0; nx < 20; ++nx)
            largest = std::max(largest, std::abs(along_y(h, y, nx)));
    for (int y = 0; y < size; y += 7)
        for (int nx = 0; nx < 30; ++nx) {
            const Complex truth = along_y(h, y, nx);
            EXPECT_LE(std::abs(columns.at(y, nx) - truth), 1e-5 * largest) << y << ", " << nx;
            EXPECT_LE(std::abs(source.at(y, nx) - truth), 1e-5 * largest) << y << ", " << nx;
        }
}

TEST(Images, every_map_of_both_devices_is_drawn_and_the_same) {
    const std::string native = draw("native"), vulkan = draw("llvmpipe");
    for (const sea::FieldInfo& field : sea::field_table) {
        if (field.field == sea::Field::foam) // a history, not a stage of a keyframe
            continue;
        const std::string name(field.name);
        EXPECT_TRUE(std::filesystem::exists(native + name + ".png"));
        const ArrayFile a(native + name + ".exr"), b(vulkan + name + ".exr");
        double squares = 0, worst = 0;
        for (std::size_t i = 0; i < a.first.size(); ++i) {
            squares += static_cast<double>(a.first[i]) * static_cast<double>(a.first[i]);
            worst = std::max(worst, std::abs(static_cast<double>(a.first[i] - b.first[i])));
        }
        EXPECT_GT(squares, 0) << name;
        EXPECT_LE(worst, 1e-5 * 4 * std::sqrt(squares / (size * size))) << name;
    }
}

// Four pixels a point, north up; red is above the middle, which is one for the Jacobian, blue below.
TEST(Images, pictures_of_maps_show_the_numbers_beside_them) {
    const std::string stem = draw("native");
    for (const char* name : {"height", "slope_y", "jacobian"}) {
        const ArrayFile map(stem + name + ".exr");
        const Pixels pixels(stem + name + ".png");
        ASSERT_EQ(pixels.width, 4 * size);
        const double middle = std::string(name) == "jacobian" ? 1.0 : 0.0;
        double largest = 0;
        for (const float value : map.first)
            largest = std::max(largest, std::abs(static_cast<double>(value) - middle));
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const auto value =
                    static_cast<double>(map.first[static_cast<std::size_t>(y * size + x)]);
                const double share = (value - middle) / largest;
                const plot::Color at = pixels.at(4 * x + 2, 4 * (size - 1 - y) + 2);
                // White is the middle; the ends are (180, 40, 30) and (20, 80, 170).
                ASSERT_NEAR(at.red, 255 - (share < 0 ? 235 : 75) * std::abs(share), 1)
                    << name << ": " << x << ", " << y;
                ASSERT_NEAR(at.blue, 255 - (share < 0 ? 85 : 225) * std::abs(share), 1)
                    << name << ": " << x << ", " << y;
            }
    }
}

// Magnitudes over six decades, from white to dark; the middle of the picture is k = 0, which is none.
TEST(Images, pictures_of_spectra_show_magnitudes_on_a_logarithmic_scale) {
    const std::string stem = draw("native");
    const ArrayFile h0(stem + "h0.exr");
    const Pixels pixels(stem + "h0.png");
    ASSERT_EQ(pixels.width, 4 * size);
    double largest = 0;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column)
            largest = std::max(largest, std::abs(h0.at(row, column)));
    std::array<int, 3> seen{};
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            const double magnitude = std::abs(h0.at(row, column));
            const double level = magnitude > 0 ? 1 + std::log10(magnitude / largest) / 6 : 0.0;
            const plot::Color color = plot::sea_color(std::clamp(level, 0.0, 1.0));
            const plot::Color at = pixels.at(4 * column + 2, 4 * (size - 1 - row) + 2);
            ASSERT_NEAR(at.red, color.red, 2) << row << ", " << column;
            ASSERT_NEAR(at.blue, color.blue, 2) << row << ", " << column;
            ++seen[level <= 0 ? 0 : level < 0.7 ? 1 : 2];
        }
    for (const int count : seen)
        EXPECT_GT(count, 30) << "none, little and much are all there";
}

TEST(Images, a_device_that_is_not_there_is_one_line) {
    const std::string scene = tests::folder().write("images.toml", scene_text);
    const Output ran = tests::run_program("seaway-inspect", scene + " --device nowhere --images " +
                                                                tests::folder().file("none"));
    EXPECT_EQ(ran.status, 2);
    EXPECT_EQ(ran.error_lines(), 1) << ran.err;
}

} // namespace
} // namespace seaway
