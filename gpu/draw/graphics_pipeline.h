// SPDX-License-Identifier: Apache-2.0
// GraphicsPipeline: a vertex and a fragment shader that draw triangles to an Offscreen or a window.
// Vertices have no attributes: shaders fetch what they need by gl_VertexIndex. As with kernels,
// bindings and push constants are read from the SPIR-V and compared with what the caller expects.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "gpu/bindings.h"
#include "gpu/commands.h"
#include "gpu/device.h"
#include "gpu/kernel.h"

namespace seaway::gpu {

/// Which fragments are kept, by reversed depth (0: infinitely far).
enum class DepthTest {
    nearer,  ///< or equally near; they become what is nearest
    covered, ///< infinitely far ones where something has been drawn; depth stays
    bare,    ///< infinitely far ones where nothing has been drawn; depth stays
};

struct GraphicsOptions {
    VkFormat colour_format = VK_FORMAT_R32G32B32A32_SFLOAT;
    VkFormat depth_format = VK_FORMAT_UNDEFINED; ///< VK_FORMAT_UNDEFINED: no depth, no test
    DepthTest test = DepthTest::nearer;
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
    bool blended =
        false; ///< laid over what is there, by alpha; not every device can, of every format
};

class GraphicsPipeline {
  public:
    GraphicsPipeline() = default;
    /// Binding i of set 0 is bindings[i]; each stage may use any part of them. `name` is for
    /// messages.
    static Result<GraphicsPipeline> create(Device& device, std::string_view name,
                                           std::span<const std::uint32_t> vertex_spirv,
                                           std::span<const std::uint32_t> fragment_spirv,
                                           std::span<const ExpectedBinding> bindings,
                                           const GraphicsOptions& options);

    /// One resource a binding, in order.
    Result<Bindings> bind(Device& device, std::span<const Resource> resources) const {
        return Bindings::create(device, set_layout_.get(), bindings_, resources);
    }

    /// Binds it and its resources for the draws that follow.
    void record_bind(Commands& commands, const Bindings& bindings) const;

    VkPipeline get() const { return pipeline_.get(); }

  private:
    std::vector<ShaderBinding> bindings_;
    OwnedSetLayout set_layout_;
    OwnedPipelineLayout layout_;
    OwnedPipeline pipeline_;
};

} // namespace seaway::gpu
