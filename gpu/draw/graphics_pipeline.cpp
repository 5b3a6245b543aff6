// SPDX-License-Identifier: Apache-2.0
#include "gpu/draw/graphics_pipeline.h"

#include "gpu/call.h"

namespace seaway::gpu {

namespace {

Result<OwnedShaderModule> create_module(Device& device, std::span<const std::uint32_t> spirv) {
    const VkShaderModuleCreateInfo info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                        .codeSize = spirv.size_bytes(),
                                        .pCode = spirv.data()};
    VkShaderModule handle = VK_NULL_HANDLE;
    SEAWAY_TRY(
        call("vkCreateShaderModule", vkCreateShaderModule, device.get(), &info, nullptr, &handle));
    return OwnedShaderModule(device.get(), handle);
}

/// Every binding of the stage must be one that the program knows, of the same type.
Result<void> compare(const ShaderInterface& shader, std::span<const ExpectedBinding> expected) {
    for (const ShaderBinding& binding : shader.bindings) {
        const bool known = binding.set == 0 && binding.binding < expected.size();
        if (!known || expected[binding.binding].name != binding.name ||
            expected[binding.binding].type != binding.type || binding.count != 1)
            return Error{"binding " + std::to_string(binding.binding) + " of set " +
                         std::to_string(binding.set) + " is \"" + binding.name + "\" (" +
                         descriptor_type_name(binding.type) + ") in the shader and " +
                         (known ? "\"" + std::string(expected[binding.binding].name) + "\" (" +
                                      descriptor_type_name(expected[binding.binding].type) + ")"
                                : "nothing") +
                         " in the program"};
    }
    if (shader.push_constant_bytes != 0)
        return Error{"graphics pipelines take no push constants"};
    return {};
}

// What is the same for every pipeline.
constexpr VkPipelineVertexInputStateCreateInfo no_attributes{
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
constexpr VkPipelineInputAssemblyStateCreateInfo assembly{
    .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
    .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
constexpr VkPipelineViewportStateCreateInfo viewport{
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
    .viewportCount = 1,
    .scissorCount = 1};
constexpr VkPipelineRasterizationStateCreateInfo raster{
    .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
    .polygonMode = VK_POLYGON_MODE_FILL,
    .cullMode = VK_CULL_MODE_NONE,
    .lineWidth = 1};
constexpr VkPipelineColorBlendAttachmentState opaque{.colorWriteMask = 0xf};
constexpr VkPipelineColorBlendAttachmentState over{
    .blendEnable = VK_TRUE,
    .srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA,
    .dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
    .colorBlendOp = VK_BLEND_OP_ADD,
    .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
    .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
    .alphaBlendOp = VK_BLEND_OP_ADD,
    .colorWriteMask = 0xf};
constexpr VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
constexpr VkPipelineDynamicStateCreateInfo dynamic{
    .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
    .dynamicStateCount = 2,
    .pDynamicStates = dynamic_states};

bool blends(Device& device, VkFormat format) {
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(device.physical(), format, &properties);
    return (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT) != 0;
}

VkCompareOp compare_of(DepthTest test) {
    switch (test) {
    case DepthTest::covered:
        return VK_COMPARE_OP_LESS;
    case DepthTest::bare:
        return VK_COMPARE_OP_EQUAL;
    case DepthTest::nearer:
        break;
    }
    return VK_COMPARE_OP_GREATER_OR_EQUAL;
}

Result<OwnedPipeline> create_pipeline(Device& device, VkPipelineLayout layout,
                                      std::span<const VkPipelineShaderStageCreateInfo> stages,
                                      const GraphicsOptions& options) {
    const VkPipelineMultisampleStateCreateInfo multisample{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = options.samples};
    const VkPipelineDepthStencilStateCreateInfo depth{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = options.depth_format != VK_FORMAT_UNDEFINED,
        .depthWriteEnable =
            options.depth_format != VK_FORMAT_UNDEFINED && options.test == DepthTest::nearer,
        .depthCompareOp = compare_of(options.test)};
    const VkPipelineColorBlendStateCreateInfo blend{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = options.blended ? &over : &opaque};
    const VkPipelineRenderingCreateInfo rendering{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .colorAttachmentCount = 1,
        .pColorAttachmentFormats = &options.colour_format,
        .depthAttachmentFormat = options.depth_format};
    const VkGraphicsPipelineCreateInfo info{.sType =
                                                VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                            .pNext = &rendering,
                                            .stageCount = static_cast<std::uint32_t>(stages.size()),
                                            .pStages = stages.data(),
                                            .pVertexInputState = &no_attributes,
                                            .pInputAssemblyState = &assembly,
                                            .pViewportState = &viewport,
                                            .pRasterizationState = &raster,
                                            .pMultisampleState = &multisample,
                                            .pDepthStencilState = &depth,
                                            .pColorBlendState = &blend,
                                            .pDynamicState = &dynamic,
                                            .layout = layout};
    VkPipeline pipeline = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateGraphicsPipelines", vkCreateGraphicsPipelines, device.get(),
                    VkPipelineCache(VK_NULL_HANDLE), 1u, &info, nullptr, &pipeline));
    return OwnedPipeline(device.get(), pipeline);
}

} // namespace

Result<GraphicsPipeline> GraphicsPipeline::create(Device& device, std::string_view name,
                                                  std::span<const std::uint32_t> vertex_spirv,
                                                  std::span<const std::uint32_t> fragment_spirv,
                                                  std::span<const ExpectedBinding> bindings,
                                                  const GraphicsOptions& options) {
    const auto failed = [&](const Error& error) {
        return Error{error.kind, "pipeline \"" + std::string(name) + "\": " + error.message};
    };
    if (!device.info().graphics)
        return failed({device.info().name + " cannot draw"});
    if (options.blended && !blends(device, options.colour_format))
        return failed({device.info().name + " cannot lay anything over pictures of this format"});
    const std::span<const std::uint32_t> spirv[] = {vertex_spirv, fragment_spirv};
    std::string entry_points[2];
    OwnedShaderModule modules[2];
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    for (std::size_t i = 0; i < 2; ++i) {
        const Result<ShaderInterface> shader = reflect(spirv[i]);
        if (!shader)
            return failed(shader.error());
        if (Result<void> same = compare(*shader, bindings); !same)
            return failed(same.error());
        Result<OwnedShaderModule> module = create_module(device, spirv[i]);
        if (!module)
            return failed(module.error());
        modules[i] = std::move(*module);
        entry_points[i] = shader->entry_point;
        stages.push_back({.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                          .stage = shader->stage,
                          .module = modules[i].get(),
                          .pName = entry_points[i].c_str()});
    }
    GraphicsPipeline made;
    for (std::size_t i = 0; i < bindings.size(); ++i)
        made.bindings_.push_back({.binding = static_cast<std::uint32_t>(i),
                                  .type = bindings[i].type,
                                  .name = std::string(bindings[i].name)});
    Result<OwnedSetLayout> set = create_set_layout(
        device, made.bindings_, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT);
    if (!set)
        return failed(set.error());
    made.set_layout_ = std::move(*set);
    const VkDescriptorSetLayout set_layout = made.set_layout_.get();
    const VkPipelineLayoutCreateInfo layout_info{.sType =
                                                     VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                                 .setLayoutCount = 1,
                                                 .pSetLayouts = &set_layout};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    if (Result<void> created = call("vkCreatePipelineLayout", vkCreatePipelineLayout, device.get(),
                                    &layout_info, nullptr, &layout);
        !created)
        return failed(created.error());
    made.layout_ = OwnedPipelineLayout(device.get(), layout);
    Result<OwnedPipeline> pipeline = create_pipeline(device, layout, stages, options);
    if (!pipeline)
        return failed(pipeline.error());
    made.pipeline_ = std::move(*pipeline);
    return made;
}

void GraphicsPipeline::record_bind(Commands& commands, const Bindings& bindings) const {
    const VkDescriptorSet set = bindings.get();
    vkCmdBindPipeline(commands.get(), VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_.get());
    vkCmdBindDescriptorSets(commands.get(), VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 0, 1,
                            &set, 0, nullptr);
}

} // namespace seaway::gpu
