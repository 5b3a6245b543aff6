// SPDX-License-Identifier: Apache-2.0
// What memory gives at best.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "base/result.h"

namespace seaway::bench {

/// Larger than what caches hold.
inline constexpr std::size_t moved_bytes = std::size_t{64} << 20;

/// What memory gives at best: as many bytes as maps have, written by nothing but stores.
class Mover {
  public:
    virtual ~Mover() = default;
    virtual std::string name() const = 0;
    /// That it takes for `bytes`, at most moved_bytes.
    virtual Result<double> seconds(std::size_t bytes) = 0;
};

/// By stores of all threads of this processor.
std::unique_ptr<Mover> native_mover();
/// By a kernel on a Vulkan device, an index.
Result<std::unique_ptr<Mover>> device_mover(const std::string& pick);
/// From a device's memory to this processor's, by way of memory that both see, as on a discrete GPU, whatever it is.
Result<std::unique_ptr<Mover>> readback_mover(const std::string& pick);

} // namespace seaway::bench
