// SPDX-License-Identifier: Apache-2.0
// Kernel: a compute pipeline. Its bindings, push constants and workgroup size are read from the
// SPIR-V and compared with what the caller expects; a difference is an error at start-up that names
// both, not a wrong picture later.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "gpu/bindings.h"
#include "gpu/device.h"
#include "gpu/spirv.h"

namespace seaway::gpu {

struct ExpectedBinding {
    std::string_view name;
    VkDescriptorType type;
};

/// What the C++ side believes of a kernel. Binding i of set 0 is bindings[i].
struct KernelExpectation {
    std::vector<ExpectedBinding> bindings;
    std::uint32_t push_constant_bytes = 0;
    std::array<std::uint32_t, 3> local_size{1, 1, 1};
};

struct KernelOptions {
    bool full_subgroups = false;          ///< no lane idle; local size x a multiple of the subgroup
    std::vector<std::uint32_t> constants; ///< specialisation constants 0, 1, ...
};

class Kernel {
  public:
    Kernel() = default;
    /// `name` is for messages. The device's limits are checked too.
    static Result<Kernel> create(Device& device, std::string_view name,
                                 std::span<const std::uint32_t> spirv,
                                 const KernelExpectation& expected,
                                 const KernelOptions& options = {});

    /// One resource a binding, in order.
    Result<Bindings> bind(Device& device, std::span<const Resource> resources) const {
        return Bindings::create(device, set_layout_.get(), interface_.bindings, resources);
    }
    Result<Bindings> bind(Device& device, std::initializer_list<Resource> resources) const {
        return bind(device, std::span(resources.begin(), resources.size()));
    }

    VkPipeline get() const { return pipeline_.get(); }
    VkPipelineLayout layout() const { return layout_.get(); }
    std::uint32_t push_constant_bytes() const { return interface_.push_constant_bytes; }
    const std::string& name() const { return name_; }

  private:
    std::string name_;
    ShaderInterface interface_;
    OwnedSetLayout set_layout_;
    OwnedPipelineLayout layout_;
    OwnedPipeline pipeline_;
};

} // namespace seaway::gpu
