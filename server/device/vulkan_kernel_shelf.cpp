// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_kernel_shelf.h"

#include <algorithm>
#include <string_view>

#include "base/hash.h"
#include "server/device/synthesizer.h"
#include "server/device/vulkan_check.h"

namespace seaway::server {

namespace {

/// Of the kernels that there is a choice of.
std::uint32_t fingerprint(std::span<const shaders::Transform* const> designs) {
    std::string text;
    for (const shaders::Transform* design : designs)
        for (const shaders::Pass& pass : design->passes) {
            const auto bytes = std::as_bytes(pass.shader.spirv);
            const std::string_view words(reinterpret_cast<const char*>(bytes.data()), bytes.size());
            text += std::string(pass.shader.name) + hex_hash(words);
        }
    return static_cast<std::uint32_t>(text_hash(text));
}

} // namespace

void KernelShelf::note(const std::string& text) {
    if (notes_.find(text) == std::string::npos) // of each size the same file
        notes_ += "; " + text;
}

std::string KernelShelf::description() const {
    std::string text;
    for (const auto& [key, kernels] : kernels_)
        text += " " + std::string(kernels->transform->design) + ":" + std::to_string(key.first) +
                (key.second ? "" : " (all modes)");
    return text + notes_;
}

KernelShelf::Designs KernelShelf::fitting(int size, bool band_limited, bool to_be_tried) const {
    Designs designs = fitting_transforms(device_.info(), size, band_limited, to_be_tried);
    if (any_device_)
        std::erase_if(designs, [](const shaders::Transform* design) {
            return design->lanes != 0 || design->shares_memory;
        });
    return designs;
}

const shaders::Transform* KernelShelf::remembered(const KernelChoice& asked,
                                                  const Designs& designs) {
    if (tuning_.file.empty() || tuning_.again)
        return nullptr;
    const Result<std::vector<KernelChoice>> choices = read_kernel_choices(tuning_.file);
    if (!choices)
        note(choices.error().message);
    for (const KernelChoice& choice : choices ? *choices : std::vector<KernelChoice>())
        if (choice.is_of_the_same(asked) && choice.fingerprint == asked.fingerprint)
            for (const shaders::Transform* design : designs)
                if (design->design == choice.design)
                    return design;
    return nullptr;
}

Result<KernelShelf::Made> KernelShelf::made_and_checked(const shaders::Transform& design) {
    SEAWAY_TRY_LET(SynthesisKernels made, SynthesisKernels::create(device_, design));
    const Result<void> checked = check_device(device_, made);
    if (checked)
        return std::make_unique<SynthesisKernels>(std::move(made));
    if (!checked.error().is(DeviceError::cannot_do_this_sea))
        return checked.error(); // another design would fail as well
    wrong_ = checked.error();
    note("refused " + std::string(design.design) + ": " + wrong_.message);
    return Made();
}

// What a driver cannot compile, or has no memory for, is the same at every start.
Result<KernelShelf::Made> KernelShelf::tried(const shaders::Transform& design) {
    Result<Made> made = made_and_checked(design);
    if (made || made.error().is(VK_ERROR_DEVICE_LOST))
        return made;
    note("passed over " + std::string(design.design) + ": " + made.error().message);
    return Made();
}

Result<KernelShelf::Made> KernelShelf::fastest(const KernelChoice& asked, const Designs& designs) {
    std::vector<Made> made;
    std::vector<const SynthesisKernels*> timed;
    for (const shaders::Transform* design : designs) {
        SEAWAY_TRY_LET(Made kernels, tried(*design));
        if (!kernels)
            continue;
        timed.push_back(kernels.get());
        made.push_back(std::move(kernels));
    }
    if (made.empty())
        return Made();
    const Result<std::vector<double>> seconds = time_kernels(device_, timed);
    if (!seconds && seconds.error().is(VK_ERROR_DEVICE_LOST))
        return seconds.error();
    if (!seconds) { // all of them are in memory at once, where one alone may fit
        note("not measured: " + seconds.error().message);
        return Made();
    }
    const std::size_t best = fastest_of(*seconds);
    KernelChoice choice = asked;
    choice.design = timed[best]->transform->design;
    choice.seconds = (*seconds)[best];
    if (!tuning_.file.empty())
        if (const Result<void> kept = remember_kernel_choice(tuning_.file, choice); !kept)
            note(kept.error().message);
    return std::move(made[best]);
}

Result<KernelShelf::Made> KernelShelf::first(const Designs& designs) {
    for (const shaders::Transform* design : designs) {
        SEAWAY_TRY_LET(Made made, made_and_checked(*design));
        if (made)
            return made;
    }
    return Made();
}

Result<KernelShelf::Made> KernelShelf::chosen(int size, bool band_limited) {
    const Designs all = fitting(size, band_limited, true);
    const KernelChoice asked{.device = kernel_choice_name(device_.info().name),
                             .driver = kernel_choice_name(device_.info().driver),
                             .size = size,
                             .band_limited = band_limited,
                             .fingerprint = fingerprint(all)};
    if (const shaders::Transform* known = remembered(asked, all)) {
        SEAWAY_TRY_LET(Made made, tried(*known));
        if (made)
            return made;
    } else if (all.size() > 1 && tuning_.measures_on(device_.info())) {
        SEAWAY_TRY_LET(Made made, fastest(asked, all));
        if (made)
            return made;
    }
    return first(fitting(size, band_limited, false));
}

Result<const SynthesisKernels*> KernelShelf::get(int size, bool band_limited) {
    if (const auto found = kernels_.find({size, band_limited}); found != kernels_.end())
        return static_cast<const SynthesisKernels*>(found->second.get());
    wrong_ = {DeviceError::cannot_do_this_sea,
              "cascade of size " + std::to_string(size) + ": no Vulkan kernels for it; there are " +
                  transform_sizes() + " (other sizes: the native device from 16 to 1024)"};
    Result<Made> made = chosen(size, band_limited);
    if (!made)
        return Error{made.error().kind, device_.info().name + ": " + made.error().message};
    if (!*made)
        return Error{wrong_.kind, device_.info().name + ": " + wrong_.message};
    const SynthesisKernels* kernels = made->get();
    kernels_[{size, band_limited}] = std::move(*made);
    return kernels;
}

} // namespace seaway::server
