// SPDX-License-Identifier: Apache-2.0
// NativeTransform: the modes of one cascade, laid out for the CPU kernels. Made once per sea state,
// then shared by any number of runners (native_runner.h), which turn it into maps.
//
// Immutable: every call is thread-safe. Memory: 32 bytes a mode with kx >= 0 inside the band.
#pragma once

#include <cstdint>
#include <memory>

#include "base/instructions.h"
#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

namespace native {
class Batch;
struct TransformState;
} // namespace native

class NativeTransform {
  public:
    static constexpr int smallest_size = 16;
    static constexpr int largest_size = 1024;

    /// `modes.spec.size` must be a power of two, 16 .. 1024; h0 and rate hold size^2 entries; row
    /// and column -size/2 are taken as zero. An error names the value that is out of range.
    /// `choppiness` enters the Jacobian only. Instructions that this machine does not have: our
    /// bug, checked.
    static Result<NativeTransform> create(const CascadeModes& modes, Choppiness choppiness,
                                          Instructions instructions = best_instructions());
    NativeTransform(NativeTransform&&) noexcept;
    NativeTransform& operator=(NativeTransform&&) noexcept;
    ~NativeTransform();

    int size() const;

  private:
    friend class native::Batch;
    explicit NativeTransform(std::unique_ptr<const native::TransformState> state);
    std::unique_ptr<const native::TransformState> state_;
};

} // namespace seaway::sea
