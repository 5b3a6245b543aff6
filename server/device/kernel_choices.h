// SPDX-License-Identifier: Apache-2.0
// KernelChoices: which design of the kernels a device ran fastest, as it was measured once, in a file that programs share.
//
//     seaway kernels 1
//     NAME <tab> DRIVER <tab> SIZE <tab> band|all <tab> FINGERPRINT <tab> DESIGN <tab> MICROSECONDS
//
// A cache: whoever cannot read or write it measures, or goes without. It is written anew beside itself and takes the old
// one's place at once, so that others read the one or the other; of two who write at one moment a row may be lost, and is
// measured again. FINGERPRINT is of all kernels that were to be chosen among: others have another choice.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace seaway::server {

/// $XDG_CACHE_HOME/seaway/kernels.tsv, or that below ~/.cache; empty: there is no home.
std::string kernel_choices_path();

/// As it may stand in a row: names come from drivers.
std::string kernel_choice_name(std::string name);

struct KernelChoice {
    std::string device, driver; ///< as kernel_choice_name() gives them
    int size = 0;
    bool band_limited = false;
    std::uint32_t fingerprint = 0;
    std::string design;
    double seconds = 0; ///< of a keyframe of eight fields, when it was measured

    bool is_of_the_same(const KernelChoice& other) const {
        return device == other.device && driver == other.driver && size == other.size &&
               band_limited == other.band_limited;
    }
};

/// Which of these took the least time; of at least one.
std::size_t fastest_of(std::span<const double> seconds);

/// All that the file holds; nothing where there is none. An error: what is no such file, by the line that says so, or what
/// cannot be read.
Result<std::vector<KernelChoice>> read_kernel_choices(const std::string& path);

/// Puts a choice beside what the file holds, in place of one of the same device, driver, size and band; a file that cannot
/// be read is replaced, unless it is no regular one. Makes the folder. An error: nothing was remembered.
Result<void> remember_kernel_choice(const std::string& path, const KernelChoice& choice);

} // namespace seaway::server
