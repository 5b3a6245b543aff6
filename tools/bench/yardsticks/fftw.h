// SPDX-License-Identifier: Apache-2.0
// FFTW in single precision, where this machine has it: looked for when it is asked about, needed by nothing.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"

namespace seaway::bench {

class Fftw {
  public:
    /// An error names the library that is not there.
    static Result<std::unique_ptr<Fftw>> open();
    virtual ~Fftw() = default;
    virtual std::string name() const = 0;
    /// Seconds of so many transforms of half spectra to real maps of size x size, by two threads, each with its own plan:
    /// of the thread that took longer, without the copies that spectra are filled by. The first call of a size measures plans (FFTW_MEASURE), some tenths of a second.
    virtual Result<double> seconds(int size, int count) = 0;
};

} // namespace seaway::bench
