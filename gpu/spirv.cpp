// SPDX-License-Identifier: Apache-2.0
// Opcodes and enumerants: SPIR-V specification 1.6, section 3.
#include "gpu/spirv.h"

#include <algorithm>
#include <map>
#include <utility>

namespace seaway::gpu {

namespace {

enum Op : std::uint32_t {
    op_name = 5,
    op_entry_point = 15,
    op_execution_mode = 16,
    op_type_int = 21,
    op_type_float = 22,
    op_type_vector = 23,
    op_type_matrix = 24,
    op_type_image = 25,
    op_type_sampled_image = 27,
    op_type_array = 28,
    op_type_struct = 30,
    op_type_pointer = 32,
    op_constant = 43,
    op_variable = 59,
    op_decorate = 71,
    op_member_decorate = 72,
    op_execution_mode_id = 331,
};
enum Decoration : std::uint32_t {
    decoration_buffer_block = 3,
    decoration_array_stride = 6,
    decoration_matrix_stride = 7,
    decoration_binding = 33,
    decoration_set = 34,
    decoration_offset = 35,
};
enum Storage : std::uint32_t {
    storage_uniform = 2,
    storage_push_constant = 9,
    storage_buffer = 12,
};
constexpr std::uint32_t mode_local_size = 17;
constexpr std::uint32_t mode_local_size_id = 38;
constexpr std::uint32_t dim_buffer = 5;

using Words = std::span<const std::uint32_t>;

std::string text_of(Words words) {
    std::string text;
    for (const std::uint32_t word : words)
        for (int shift = 0; shift < 32; shift += 8) {
            const char c = static_cast<char>(word >> shift);
            if (c == 0)
                return text;
            text += c;
        }
    return text;
}

class Module {
  public:
    Result<void> read(Words words);
    ShaderInterface interface() const;

  private:
    void take(std::uint32_t op, Words operands);
    void take_type_or_variable(std::uint32_t op, Words operands);
    std::uint32_t size_of(std::uint32_t type) const;
    std::uint32_t member_size(std::uint32_t structure, std::uint32_t member) const;
    std::uint32_t decoration(std::uint32_t id, std::uint32_t what, std::uint32_t otherwise) const {
        const auto found = decorations_.find({id, what});
        return found == decorations_.end() ? otherwise : found->second;
    }
    const Words* type(std::uint32_t id) const {
        const auto found = types_.find(id);
        return found == types_.end() ? nullptr : &found->second.second;
    }
    std::uint32_t type_op(std::uint32_t id) const {
        const auto found = types_.find(id);
        return found == types_.end() ? 0 : found->second.first;
    }
    VkDescriptorType descriptor_type(std::uint32_t storage, std::uint32_t type_id) const;

    struct Variable {
        std::uint32_t id, pointer_type, storage;
    };
    std::map<std::uint32_t, std::string> names_;
    std::map<std::uint32_t, std::pair<std::uint32_t, Words>> types_; // id: op, operands after id
    std::map<std::uint32_t, std::uint32_t> constants_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> decorations_;
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> member_decorations_;
    std::vector<Variable> variables_;
    std::array<std::uint32_t, 3> local_size_ids_{}; // ids of constants; 0: given as numbers
    ShaderInterface out_;
};

Result<void> Module::read(Words words) {
    constexpr std::uint32_t magic = 0x07230203;
    constexpr std::size_t header_words = 5;
    if (words.size() < header_words || words[0] != magic)
        return Error{"not a SPIR-V module"};
    for (std::size_t at = header_words; at < words.size();) {
        const std::uint32_t length = words[at] >> 16;
        if (length == 0 || at + length > words.size())
            return Error{"SPIR-V module is cut off at word " + std::to_string(at)};
        take(words[at] & 0xffff, words.subspan(at + 1, length - 1));
        at += length;
    }
    return {};
}

void Module::take(std::uint32_t op, Words operands) {
    const std::size_t n = operands.size();
    if (op == op_name && n >= 2) {
        names_[operands[0]] = text_of(operands.subspan(1));
    } else if (op == op_entry_point && n >= 3) {
        constexpr std::uint32_t model_vertex = 0, model_fragment = 4;
        out_.entry_point = text_of(operands.subspan(2));
        out_.stage = operands[0] == model_vertex     ? VK_SHADER_STAGE_VERTEX_BIT
                     : operands[0] == model_fragment ? VK_SHADER_STAGE_FRAGMENT_BIT
                                                     : VK_SHADER_STAGE_COMPUTE_BIT;
    } else if (op == op_execution_mode && n >= 5 && operands[1] == mode_local_size) {
        out_.local_size = {operands[2], operands[3], operands[4]};
    } else if (op == op_execution_mode_id && n >= 5 && operands[1] == mode_local_size_id) {
        local_size_ids_ = {operands[2], operands[3], operands[4]};
    } else if (op == op_decorate && n >= 2) {
        decorations_[{operands[0], operands[1]}] = n >= 3 ? operands[2] : 1;
    } else if (op == op_member_decorate && n >= 4) {
        member_decorations_[{operands[0], operands[1], operands[2]}] = operands[3];
    } else if (op == op_constant && n >= 3) {
        constants_[operands[1]] = operands[2];
    } else {
        take_type_or_variable(op, operands);
    }
}

void Module::take_type_or_variable(std::uint32_t op, Words operands) {
    if (op >= op_type_int && op <= op_type_pointer && !operands.empty())
        types_[operands[0]] = {op, operands.subspan(1)};
    else if (op == op_variable && operands.size() >= 3)
        variables_.push_back({operands[1], operands[0], operands[2]});
}

std::uint32_t Module::member_size(std::uint32_t structure, std::uint32_t member) const {
    const std::uint32_t member_type = (*type(structure))[member];
    if (type_op(member_type) == op_type_matrix) {
        const auto stride = member_decorations_.find({structure, member, decoration_matrix_stride});
        if (stride != member_decorations_.end())
            return (*type(member_type))[1] * stride->second;
    }
    return size_of(member_type);
}

std::uint32_t Module::size_of(std::uint32_t id) const {
    const Words* operands = type(id);
    if (operands == nullptr || operands->empty())
        return 0;
    switch (type_op(id)) {
    case op_type_int:
    case op_type_float:
        return (*operands)[0] / 8;
    case op_type_vector:
        return (*operands)[1] * size_of((*operands)[0]);
    case op_type_array: {
        const auto length = constants_.find((*operands)[1]);
        return length == constants_.end() ? 0
                                          : length->second * decoration(id, decoration_array_stride,
                                                                        size_of((*operands)[0]));
    }
    case op_type_struct: {
        std::uint32_t end = 0;
        for (std::uint32_t member = 0; member < operands->size(); ++member) {
            const auto offset = member_decorations_.find({id, member, decoration_offset});
            if (offset != member_decorations_.end())
                end = std::max(end, offset->second + member_size(id, member));
        }
        return end;
    }
    default:
        return 0;
    }
}

VkDescriptorType Module::descriptor_type(std::uint32_t storage, std::uint32_t type_id) const {
    if (storage == storage_buffer ||
        (storage == storage_uniform && decoration(type_id, decoration_buffer_block, 0) != 0))
        return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    if (storage == storage_uniform)
        return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    const bool combined = type_op(type_id) == op_type_sampled_image;
    const std::uint32_t image_id = combined ? (*type(type_id))[0] : type_id;
    if (type_op(image_id) != op_type_image)
        return VK_DESCRIPTOR_TYPE_SAMPLER;
    const Words& image = *type(image_id); // sampled type, dim, depth, arrayed, ms, sampled, format
    const bool is_storage = image.size() > 5 && image[5] == 2;
    if (image.size() > 1 && image[1] == dim_buffer)
        return is_storage ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER
                          : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    if (combined)
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    return is_storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
}

ShaderInterface Module::interface() const {
    ShaderInterface out = out_;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (const auto size = constants_.find(local_size_ids_[axis]); size != constants_.end())
            out.local_size[axis] = size->second;
    for (const Variable& variable : variables_) {
        const Words* pointer = type(variable.pointer_type);
        if (pointer == nullptr || pointer->size() < 2)
            continue;
        std::uint32_t type_id = (*pointer)[1];
        if (variable.storage == storage_push_constant) {
            out.push_constant_bytes = size_of(type_id);
            continue;
        }
        if (decorations_.count({variable.id, decoration_binding}) == 0)
            continue;
        ShaderBinding binding;
        if (type_op(type_id) == op_type_array) {
            const auto length = constants_.find((*type(type_id))[1]);
            binding.count = length == constants_.end() ? 1 : length->second;
            type_id = (*type(type_id))[0];
        }
        binding.set = decoration(variable.id, decoration_set, 0);
        binding.binding = decoration(variable.id, decoration_binding, 0);
        binding.type = descriptor_type(variable.storage, type_id);
        const auto own = names_.find(variable.id);
        const auto block = names_.find(type_id);
        if (own != names_.end() && !own->second.empty())
            binding.name = own->second;
        else if (block != names_.end())
            binding.name = block->second;
        out.bindings.push_back(binding);
    }
    std::sort(out.bindings.begin(), out.bindings.end(), [](const auto& a, const auto& b) {
        return std::pair(a.set, a.binding) < std::pair(b.set, b.binding);
    });
    return out;
}

} // namespace

Result<ShaderInterface> reflect(std::span<const std::uint32_t> words) {
    Module module;
    SEAWAY_TRY(module.read(words));
    return module.interface();
}

const char* descriptor_type_name(VkDescriptorType type) {
    switch (type) {
    case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
        return "storage buffer";
    case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:
        return "uniform buffer";
    case VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER:
        return "uniform texel buffer";
    case VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER:
        return "storage texel buffer";
    case VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER:
        return "combined image sampler";
    case VK_DESCRIPTOR_TYPE_STORAGE_IMAGE:
        return "storage image";
    case VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE:
        return "sampled image";
    case VK_DESCRIPTOR_TYPE_SAMPLER:
        return "sampler";
    default:
        return "other";
    }
}

} // namespace seaway::gpu
