// SPDX-License-Identifier: Apache-2.0
// What is read from a module, by modules written word by word: kinds of resources, sizes and orders that
// our own shaders do not have, or not yet.
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "gpu/spirv.h"

namespace seaway::gpu {
namespace {

using Words = std::vector<std::uint32_t>;

/// Instructions of SPIR-V 1.6, by their numbers in the specification.
struct Builder {
    Words words{0x07230203, 0x00010600, 0, 100, 0};

    void op(std::uint32_t code, const Words& operands) {
        words.push_back(static_cast<std::uint32_t>(operands.size() + 1) << 16 | code);
        words.insert(words.end(), operands.begin(), operands.end());
    }
    static Words text(const std::string& text) {
        Words packed(text.size() / 4 + 1);
        for (std::size_t i = 0; i < text.size(); ++i)
            packed[i / 4] |= static_cast<std::uint32_t>(text[i]) << 8 * (i % 4);
        return packed;
    }
    static Words join(Words first, const Words& more) {
        first.insert(first.end(), more.begin(), more.end());
        return first;
    }
    void entry_point(std::uint32_t model, const std::string& name) {
        op(15, join({model, 1}, text(name)));
    }
    void name(std::uint32_t id, const std::string& name) { op(5, join({id}, text(name))); }
    void decorate(std::uint32_t id, std::uint32_t what, std::uint32_t value) {
        op(71, {id, what, value});
    }
    void offset(std::uint32_t type, std::uint32_t member, std::uint32_t bytes) {
        op(72, {type, member, 35, bytes});
    }
    void float_type(std::uint32_t id) { op(22, {id, 32}); }
    void vector_type(std::uint32_t id, std::uint32_t part, std::uint32_t count) {
        op(23, {id, part, count});
    }
    void struct_type(std::uint32_t id, const Words& members) { op(30, join({id}, members)); }
    /// A variable through a pointer to its type.
    void variable(std::uint32_t id, std::uint32_t pointer, std::uint32_t storage,
                  std::uint32_t type) {
        op(32, {pointer, storage, type});
        op(59, {pointer, id, storage});
    }
    void place(std::uint32_t id, std::uint32_t set, std::uint32_t binding) {
        decorate(id, 34, set);
        decorate(id, 33, binding);
    }
    ShaderInterface read() const {
        const Result<ShaderInterface> read = reflect(words);
        EXPECT_TRUE(read) << read.error().message;
        return read.value();
    }
};

constexpr std::uint32_t uniform_constant = 0, uniform = 2, push_constant = 9, storage_buffer = 12;

TEST(Spirv, push_constants_end_where_the_furthest_member_ends_in_whatever_order_they_stand) {
    Builder module;
    module.float_type(10);
    module.vector_type(11, 10, 4);
    module.vector_type(12, 10, 3);
    module.struct_type(13, {10, 11, 12}); // a number at 16, four at 0, three at 32
    module.offset(13, 0, 16);
    module.offset(13, 1, 0);
    module.offset(13, 2, 32);
    module.variable(20, 21, push_constant, 13);
    EXPECT_EQ(module.read().push_constant_bytes, 32u + 12);

    Builder first;
    first.float_type(10);
    first.vector_type(11, 10, 4);
    first.struct_type(13, {11, 10}); // the furthest one stands first
    first.offset(13, 0, 48);
    first.offset(13, 1, 4);
    first.variable(20, 21, push_constant, 13);
    EXPECT_EQ(first.read().push_constant_bytes, 64u);
}

TEST(Spirv, matrices_and_arrays_are_as_long_as_their_strides_say) {
    Builder module;
    module.float_type(10);
    module.vector_type(11, 10, 3);
    module.op(24, {12, 11, 4});  // four columns of three
    module.op(21, {14, 32, 0});  // whole numbers
    module.op(43, {14, 15, 5});  // 5
    module.op(28, {16, 10, 15}); // five numbers
    module.decorate(16, 6, 8);   // eight bytes from one to the next
    module.struct_type(13, {12, 16, 14});
    module.offset(13, 0, 0);
    module.op(72, {13, 0, 7, 16}); // sixteen bytes from column to column
    module.offset(13, 1, 64);
    module.variable(20, 21, push_constant, 13);
    EXPECT_EQ(module.read().push_constant_bytes, 64u + 5 * 8);
    module.offset(13, 2, 104); // and a whole number behind them
    EXPECT_EQ(module.read().push_constant_bytes, 108u);
}

TEST(Spirv, every_kind_of_resource_is_told_from_the_others) {
    constexpr std::uint32_t dim_2d = 1, dim_buffer = 5, sampled = 1, written = 2;
    struct Row {
        VkDescriptorType type;
        std::uint32_t storage;
        void (*make)(Builder&, std::uint32_t id); ///< the type
    };
    const auto image = [](Builder& m, std::uint32_t id, std::uint32_t dim, std::uint32_t use) {
        m.op(25, {id, 10, dim, 0, 0, 0, use, 0});
    };
    static const auto make_image = image;
    const Row rows[] = {
        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, storage_buffer,
         [](Builder& m, std::uint32_t id) { m.struct_type(id, {10}); }},
        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, uniform,
         [](Builder& m, std::uint32_t id) {
             m.struct_type(id, {10});
             m.op(71, {id, 3}); // BufferBlock, as before SPIR-V 1.3
         }},
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, uniform,
         [](Builder& m, std::uint32_t id) { m.struct_type(id, {10}); }},
        {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, uniform_constant,
         [](Builder& m, std::uint32_t id) { make_image(m, id, dim_buffer, sampled); }},
        {VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, uniform_constant,
         [](Builder& m, std::uint32_t id) { make_image(m, id, dim_buffer, written); }},
        {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, uniform_constant,
         [](Builder& m, std::uint32_t id) { make_image(m, id, dim_2d, sampled); }},
        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, uniform_constant,
         [](Builder& m, std::uint32_t id) { make_image(m, id, dim_2d, written); }},
        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, uniform_constant,
         [](Builder& m, std::uint32_t id) {
             make_image(m, 50, dim_2d, sampled);
             m.op(27, {id, 50});
         }},
        {VK_DESCRIPTOR_TYPE_SAMPLER, uniform_constant,
         [](Builder& m, std::uint32_t id) { m.op(26, {id}); }},
    };
    for (const Row& row : rows) {
        Builder module;
        module.float_type(10);
        row.make(module, 40);
        module.name(30, "resource");
        module.place(30, 0, 0);
        module.variable(30, 31, row.storage, 40);
        const ShaderInterface shader = module.read();
        ASSERT_EQ(shader.bindings.size(), 1u);
        EXPECT_EQ(shader.bindings[0].type, row.type) << descriptor_type_name(row.type);
    }
}

TEST(Spirv, resources_come_by_set_and_binding_with_their_names_and_counts) {
    Builder module;
    module.float_type(10);
    module.struct_type(11, {10});
    module.op(21, {14, 32, 0});
    module.op(43, {14, 15, 3});
    module.op(28, {16, 11, 15}); // three of the block
    module.name(11, "Block");
    module.name(30, "last");
    module.place(30, 1, 0);
    module.variable(30, 31, storage_buffer, 11);
    module.place(32, 0, 4); // without a name of its own
    module.variable(32, 33, storage_buffer, 11);
    module.name(34, "three");
    module.place(34, 0, 2);
    module.variable(34, 35, storage_buffer, 16);
    module.variable(36, 37, storage_buffer, 11); // bound to nothing
    const ShaderInterface shader = module.read();
    ASSERT_EQ(shader.bindings.size(), 3u);
    const auto expect = [&](std::size_t i, std::uint32_t set, std::uint32_t binding,
                            std::uint32_t count, const char* name) {
        EXPECT_EQ(shader.bindings[i].set, set) << name;
        EXPECT_EQ(shader.bindings[i].binding, binding) << name;
        EXPECT_EQ(shader.bindings[i].count, count) << name;
        EXPECT_EQ(shader.bindings[i].name, name);
    };
    expect(0, 0, 2, 3, "three");
    expect(1, 0, 4, 1, "Block");
    expect(2, 1, 0, 1, "last");
}

TEST(Spirv, stages_entry_points_and_workgroups_are_those_of_the_module) {
    const std::pair<std::uint32_t, VkShaderStageFlagBits> stages[] = {
        {0, VK_SHADER_STAGE_VERTEX_BIT},
        {4, VK_SHADER_STAGE_FRAGMENT_BIT},
        {5, VK_SHADER_STAGE_COMPUTE_BIT}};
    for (const auto& [model, stage] : stages) {
        Builder module;
        module.entry_point(model, "begin_here");
        const ShaderInterface shader = module.read();
        EXPECT_EQ(shader.stage, stage);
        EXPECT_EQ(shader.entry_point, "begin_here");
    }
    Builder numbers;
    numbers.op(16, {1, 17, 8, 4, 2});
    EXPECT_EQ(numbers.read().local_size, (std::array<std::uint32_t, 3>{8, 4, 2}));
    Builder constants; // the numbers stand elsewhere
    constants.op(331, {1, 38, 60, 61, 62});
    for (const auto& [id, value] : {std::pair(60u, 16u), {61u, 3u}, {62u, 5u}})
        constants.op(43, {14, id, value});
    EXPECT_EQ(constants.read().local_size, (std::array<std::uint32_t, 3>{16, 3, 5}));
}

} // namespace
} // namespace seaway::gpu
