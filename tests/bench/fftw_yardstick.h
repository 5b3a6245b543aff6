// SPDX-License-Identifier: Apache-2.0
// FftwYardstick: the ocean step as FFTW programs do it, for benchmarks only.
#pragma once

#include <complex>
#include <memory>
#include <span>
#include <vector>

#include <fftw3.h>

#include "base/thread_pool.h"
#include "sea/waves/realization.h"
#include "tests/bench/fftw_evolve.h"

namespace seaway::bench {

enum class FftwProgram {
    plain,       ///< FFTW's own threads over a batch of four, scalar sine
    split_batch, ///< two threads, each its own plan over half of the batch, vectorised evolve
};

struct FreeFftw {
    void operator()(void* p) const { fftwf_free(p); }
};

/// Three cascades (or any number) of one size to four packed complex maps each.
class FftwYardstick {
  public:
    FftwYardstick(FftwProgram program, std::span<const sea::CascadeModes> cascades);
    ~FftwYardstick();
    FftwYardstick(const FftwYardstick&) = delete;
    FftwYardstick& operator=(const FftwYardstick&) = delete;

    /// Leaves packed() filled; with `planar`, also planes().
    void run(sea::TimeUs t_us, bool planar);

    /// [cascade][packed field][y][x] (re, im)
    const float* packed(std::size_t cascade, int field) const;
    /// [cascade][field][y][x], eight fields.
    std::span<const float> planes() const { return planes_; }

  private:
    struct Modes;
    struct Step;
    static void evolve_rows(const void* step, int chunk, int worker);
    static void transform_half(const void* step, int chunk, int worker);
    static void split_half(const void* step, int chunk, int worker);

    FftwProgram program_;
    int size_;
    std::vector<std::unique_ptr<Modes>> modes_;
    std::unique_ptr<float, FreeFftw> packed_;
    std::vector<float> planes_;
    fftwf_plan half_ = nullptr;  ///< two fields on one thread
    fftwf_plan batch_ = nullptr; ///< four fields on FFTW's threads
    ThreadPool pool_{2};
};

} // namespace seaway::bench
