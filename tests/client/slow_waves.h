// SPDX-License-Identifier: Apache-2.0
// A sea whose waves come when the test lets them; until then nothing else does.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/client/wave_sea.h"

namespace seaway::tests {

class SlowWaves : public WaveSea {
  public:
    std::atomic<bool> held_back = false;
    std::atomic<int> asked = 0;

    Result<server::GrantedSpectrum> spectrum(const server::SpectrumRequest& request) override {
        ++asked;
        while (held_back)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return WaveSea::spectrum(request);
    }
};

} // namespace seaway::tests
