// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_kernel_shelf.h"

#include "server/device/synthesizer.h"
#include "server/device/vulkan_check.h"

namespace seaway::server {

std::string KernelShelf::description() const {
    std::string text;
    for (const auto& [key, kernels] : kernels_)
        text += " " + std::string(kernels->transform->design) + ":" + std::to_string(key.first) +
                (key.second ? "" : " (all modes)");
    return text + refused_;
}

Result<const SynthesisKernels*> KernelShelf::get(int size, bool band_limited) {
    if (const auto found = kernels_.find({size, band_limited}); found != kernels_.end())
        return static_cast<const SynthesisKernels*>(found->second.get());
    Error last{DeviceError::cannot_do_this_sea,
               "cascade of size " + std::to_string(size) +
                   ": no Vulkan kernels for it; there are " + transform_sizes() +
                   " (other sizes: the native device up to 1024, seaway-inspect up to 2048)"};
    for (const shaders::Transform* transform :
         fitting_transforms(device_.info(), size, band_limited)) {
        if (any_device_ && transform->lanes != 0)
            continue;
        Result<SynthesisKernels> made = SynthesisKernels::create(device_, *transform);
        if (!made)
            return Error{device_.info().name + ": " + made.error().message};
        const Result<void> checked = check_device(device_, *made);
        if (checked) {
            auto kept = std::make_unique<SynthesisKernels>(std::move(*made));
            const SynthesisKernels* kernels = kept.get();
            kernels_[{size, band_limited}] = std::move(kept);
            return kernels;
        }
        last = checked.error();
        if (!last.is(DeviceError::cannot_do_this_sea))
            break; // another design would fail as well
        refused_ += "; refused " + std::string(transform->design) + ": " + last.message;
    }
    return Error{last.kind, device_.info().name + ": " + last.message};
}

} // namespace seaway::server
