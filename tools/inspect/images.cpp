// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/images.h"

#include <cctype>
#include <complex>
#include <filesystem>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "sea/waves/centred_spectrum.h"
#include "server/device/device_choice.h"
#include "tools/inspect/array_picture.h"

namespace seaway::inspect {

using server::KeyframeRequest;
using server::Synthesizer;

namespace {

/// Words of a file name: what is no letter or digit becomes "_".
std::string file_words(const std::string& text) {
    std::string words;
    for (const char c : text)
        words += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    return words;
}

class ImageWriter {
  public:
    ImageWriter(const sea::Realization& sea, const ImagesOptions& options)
        : sea_(sea), options_(options) {}

    /// h0(k) and h(k,t), in double and then as floats: the same for every device.
    Result<void> spectra(std::size_t cascade) {
        const sea::CascadeModes& modes = sea_.cascades[cascade];
        const std::vector<float> h0 = floats(sea::centred_h0(modes));
        const std::vector<float> h = floats(sea::centred_h(sea_, cascade, options_.time_us));
        Array2d array{.title = "h0(k), m",
                      .rows = modes.spec.size,
                      .columns = modes.spec.size,
                      .complex = true,
                      .north_up = true,
                      .values = h0};
        SEAWAY_TRY(write(cascade, "h0", array));
        array.title = fmt::format("h(k,t), m, t = {} s", sea::seconds_from_us(options_.time_us));
        array.time_us = options_.time_us;
        array.values = h;
        return write(cascade, "h", array);
    }

    Result<void> stages(std::size_t cascade, Synthesizer& device, const KeyframeRequest& request) {
        const Result<std::vector<server::SynthesisStage>> stages = device.stages(request);
        if (!stages)
            return stages.error();
        for (const server::SynthesisStage& stage : *stages) {
            const Array2d array{.title = stage.pass + ": " + stage.name,
                                .rows = stage.rows,
                                .columns = stage.columns,
                                .complex = stage.complex,
                                .time_us = request.time_us,
                                .values = stage.values};
            SEAWAY_TRY(write(cascade, file_words(stage.pass + "_" + stage.name), array));
        }
        return {};
    }

    Result<void> maps(const sea::Keyframe& keyframe) {
        for (const sea::Field field : keyframe.fields) {
            const sea::FieldInfo& row = sea::info(field);
            const Array2d array{.title = fmt::format("{}, {}", row.name, row.unit),
                                .rows = keyframe.size,
                                .columns = keyframe.size,
                                .middle = field == sea::Field::jacobian ? 1.0 : 0.0,
                                .north_up = true,
                                .time_us = keyframe.time_us,
                                .values = keyframe.plane(field)};
            SEAWAY_TRY(
                write(static_cast<std::size_t>(keyframe.cascade), std::string(row.name), array));
        }
        return {};
    }

    int files() const { return files_; }

  private:
    static std::vector<float> floats(const std::vector<std::complex<double>>& values) {
        std::vector<float> out;
        for (const std::complex<double>& value : values)
            out.insert(out.end(),
                       {static_cast<float>(value.real()), static_cast<float>(value.imag())});
        return out;
    }

    Result<void> write(std::size_t cascade, const std::string& name, Array2d array) {
        array.title = fmt::format("cascade {} ({:g} m), {}", cascade,
                                  sea_.cascades[cascade].spec.length_m, array.title);
        array.length_m = sea_.cascades[cascade].spec.length_m;
        const std::string stem = fmt::format("{}/cascade{}_{}", options_.folder, cascade, name);
        SEAWAY_TRY(draw_array(array, stem + ".png"));
        SEAWAY_TRY(save_array(array, stem + ".exr"));
        files_ += 2;
        return {};
    }

    const sea::Realization& sea_;
    const ImagesOptions& options_;
    int files_ = 0;
};

} // namespace

Result<int> write_images(const sea::RealizationPtr& sea, const ImagesOptions& options) {
    SEAWAY_TRY_LET(const auto device, server::make_synthesizer(options.device));
    SEAWAY_TRY(device->set_sea(sea, 1));
    std::error_code failed;
    std::filesystem::create_directories(options.folder, failed);
    if (failed)
        return Error{fmt::format("--images {}: {}", options.folder, failed.message())};
    ImageWriter writer(*sea, options);
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        const KeyframeRequest request{static_cast<int>(c), options.time_us,
                                      sea::all_fields.without({sea::Field::foam})};
        SEAWAY_TRY_LET(const auto keyframes, device->synthesize({&request, 1}));
        SEAWAY_TRY(writer.spectra(c));
        SEAWAY_TRY(writer.stages(c, *device, request));
        SEAWAY_TRY(writer.maps(*keyframes.front()));
    }
    return writer.files();
}

} // namespace seaway::inspect
