// SPDX-License-Identifier: Apache-2.0
// What arithmetic gives at best: fused products and sums of single precision, in chains that wait for nothing.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"

namespace seaway::bench {

class Arithmetic {
  public:
    virtual ~Arithmetic() = default;
    virtual std::string name() const = 0;
    /// Products and sums a second, measured now; a hundredth of a second or a few.
    virtual Result<double> operations_per_s() = 0;
    /// Its clock falls while it has nothing to do: what is measured after a rest takes three times as long.
    virtual bool rests() const = 0;
};

/// A kernel on a Vulkan device, an index.
Result<std::unique_ptr<Arithmetic>> device_arithmetic(const std::string& pick);
/// All threads of this processor, by the best instructions that it has.
std::unique_ptr<Arithmetic> native_arithmetic();

} // namespace seaway::bench
