// SPDX-License-Identifier: Apache-2.0
// Bakes a sea into OpenEXR maps: frame after frame, one file a cascade, by any synthesizer.
//
// File DIR/cascade<c>.<frame, five digits>.exr, frame n at start_us + n / rate; with `summed` one DIR/sea.<frame>.exr
// of all cascades together. Channels are named after their fields (sea/basics/field.h) and carry no
// choppiness: D is the displacement at choppiness 1, the attributes say by what to multiply. `foam` is
// the ratio of sea/foam/foam.h, of the summed sea its coverage. With `vectors` the channels are R, G, B:
// where a point goes, choppiness applied; and A: foam. Meshes lie beside the maps under the same names.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "client/view/frame_times.h"
#include "sea/basics/field.h"
#include "sea/scene/scene.h"
#include "server/device/synthesizer.h"
#include "tools/bake/mesh.h"
#include "tools/exr/exr_map.h"

namespace seaway::bake {

using client::FrameRate;
using client::frames_max;
/// Frames are within this of the sea's epoch, the first as the last.
inline constexpr double time_max_s = 1e9;

/// Of the scene or the options; stopped as it was asked to. All others are of a file or the device.
enum class BakeError { bad_options = 1, stopped };

struct BakeOptions {
    std::string folder; ///< made if it is not there
    int frames = 1;     ///< 1 .. frames_max
    int first = 0;      ///< number of the first; all are below frames_max
    FrameRate rate{.frames = 24};
    sea::TimeUs start_us = 0; ///< of frame 0; this and the last frame's within time_max_s
    /// Not empty; with foam only where the scene has it.
    sea::FieldSet fields;
    bool half = false;
    exr::ExrCompression compression = exr::ExrCompression::none;
    bool summed = false;   ///< the sea on the longest tile's square, not its cascades
    bool vectors = false;  ///< R, G, B, A in place of channels by name
    bool north_up = false; ///< line 0 of an image is the northernmost row, not the southernmost
    MeshFormat mesh = MeshFormat::none;
    UpAxis up = UpAxis::z; ///< of vectors and meshes
    /// Asked between files and between steps of foam; the files that are written then are whole.
    std::function<bool()> stops = [] { return false; };
};

struct BakeReport {
    int frames = 0;
    int files = 0;
    std::uint64_t bytes = 0;
    double synthesis_s = 0;
    double files_s = 0; ///< compressing and writing
    double total_s = 0;
};

/// Names with commas between them, or "all". An error names the one that is none and lists those
/// that are.
Result<sea::FieldSet> parse_fields(const std::string& list);

/// Sea time of frame n, to the microsecond, without drift.
sea::TimeUs frame_time(const BakeOptions& options, int frame);

/// Bakes; an error names what is out of range, the file that cannot be written or the device that
/// failed. What has been written stays.
Result<BakeReport> bake(const sea::Scene& scene, const BakeOptions& options,
                        server::Synthesizer& synthesizer);

} // namespace seaway::bake
