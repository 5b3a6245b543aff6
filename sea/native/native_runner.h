// SPDX-License-Identifier: Apache-2.0
// NativeRunner: synthesis of maps on the CPU with SIMD and threads. No FFTW, no GPU.
//
//     Result<NativeTransform> cascade = NativeTransform::create(modes, choppiness);
//     NativeRunner runner;                                  // threads and scratch, kept
//     std::vector<float> planes(fields.size() * N * N);     // as Keyframe::values
//     const NativeTask task{&*cascade, sea.phase_time(t_us), fields, planes};
//     runner.run({&task, 1});
//
// Fields are those of sea/basics/field.h except foam; `jacobian` is that of this cascade alone, with its
// choppiness. What is computed is what is asked: fields that differ by powers of kx share a
// transform along y, two rows share one along x, and columns outside the band are not touched.
//
// Accuracy: single precision with exact fixed-point phases; against the double sum the largest
// error of a map is about 2e-7 of four times its rms (a height: of Hs), at any sea time. A field has
// the same bits whatever else is asked with it, in which batch, and with any number of threads
// (vector.h says how that is kept). AVX2 and AVX-512 agree to the bit; portable kernels differ by
// rounding.
//
// Stylised waves (sea/waves/sine_waves.h) are no modes: whoever wants them adds them to the maps.
//
// One caller at a time. Throws std::bad_alloc when there is no memory for scratch. Cost:
// docs/performance/maps.md.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sea/basics/field.h"
#include "sea/basics/time.h"
#include "sea/native/native_transform.h"

namespace seaway {
class ThreadPool;
}

namespace seaway::sea {

namespace native {
struct RunnerState;
}

/// One set of maps wanted.
struct NativeTask {
    const NativeTransform* cascade;
    TimeUs phase_time_us;    ///< Realization::phase_time of the sea time
    FieldSet fields;         ///< without foam
    std::span<float> planes; ///< out: [field in table order][y][x], fields.size() * size^2 values
    /// Out, where all strains are wanted for something else: room for [xx, yy, xy][y][x], of which those that are no
    /// field are written here. Empty: they are not wanted.
    std::span<float> strains = {};

    /// Real fields that are transformed.
    FieldSet transformed() const;
};

/// What stands between the two passes: a half spectrum, transformed along y and not yet along x.
struct NativeLines {
    std::string name;                        ///< what was transformed: "h", "h/k ky", "dh/dt ky^2"
    std::vector<std::complex<float>> values; ///< [y][kx], kx = 0 .. size/2 - 1 lattice steps
};

class NativeRunner {
  public:
    /// Threads including the caller; 0: `usable_processors()`.
    explicit NativeRunner(int threads = 0);
    ~NativeRunner();
    NativeRunner(const NativeRunner&) = delete;
    NativeRunner& operator=(const NativeRunner&) = delete;

    int threads() const;
    /// For what else is to be done with maps, between two runs.
    ThreadPool& pool();

    /// Fills the planes of every task. Give tasks that are wanted together in one call: threads
    /// then never idle between them.
    void run(std::span<const NativeTask> tasks);

    /// From time to time: lets go of lines of which the last few of these calls saw no need.
    void trim();

    /// Runs one task and copies its lines, for pictures of intermediate results.
    std::vector<NativeLines> run_and_show(const NativeTask& task);

  private:
    std::unique_ptr<native::RunnerState> state_;
};

} // namespace seaway::sea
