// SPDX-License-Identifier: Apache-2.0
#include "sea/native/native_transform.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include <fmt/format.h>

#include "base/check.h"
#include "sea/native/native_state.h"

namespace seaway::sea {

namespace {

using native::Block;
using native::Kernels;
using native::TransformState;

const Kernels* find_kernels(Instructions instructions, int size) {
    const auto supported = supported_instructions();
    SEAWAY_CHECK(std::find(supported.begin(), supported.end(), instructions) != supported.end(),
                 "instructions that this machine does not have");
    switch (instructions) {
    case Instructions::portable:
        return native::portable_kernels(size);
#if defined(SEAWAY_X86)
    case Instructions::avx2:
        return native::avx2_kernels(size);
    case Instructions::avx512:
        return native::avx512_kernels(size);
#else
    case Instructions::avx2:
    case Instructions::avx512:
        break;
#endif
    }
    return nullptr;
}

bool holds_wave(const CascadeModes& modes, int kx, int ky) {
    const auto size = static_cast<std::size_t>(modes.spec.size);
    const auto at = [&](int x, int y) {
        const std::size_t mask = size - 1;
        return (static_cast<std::size_t>(y) & mask) * size + (static_cast<std::size_t>(x) & mask);
    };
    return modes.h0[at(kx, ky)] != 0.0 || modes.h0[at(-kx, -ky)] != 0.0;
}

/// Blocks up to the last one that holds a wave.
std::vector<Block> find_blocks(const CascadeModes& modes, int lanes, std::size_t& records) {
    const int half = modes.spec.size / 2;
    std::vector<Block> blocks;
    std::size_t kept = 0;
    for (int first = 0; first < half; first += lanes) {
        int reach = -1;
        for (int kx = first; kx < first + lanes; ++kx)
            for (int ky = half - 1; ky > reach; --ky)
                if (holds_wave(modes, kx, ky) || holds_wave(modes, kx, -ky))
                    reach = ky;
        blocks.push_back({records, reach});
        if (reach >= 0)
            records += static_cast<std::size_t>(2 * reach + 1);
        if (reach >= 0)
            kept = blocks.size();
    }
    blocks.resize(kept);
    return blocks;
}

/// Fills one lane of one record: mode (kx, ky) and its partner.
void write_mode(const CascadeModes& modes, int kx, int ky, std::size_t index, std::size_t lane,
                TransformState& state) {
    const auto size = static_cast<std::size_t>(modes.spec.size);
    const std::size_t mask = size - 1;
    const std::size_t here =
        (static_cast<std::size_t>(ky) & mask) * size + (static_cast<std::size_t>(kx) & mask);
    const std::size_t there =
        (static_cast<std::size_t>(-ky) & mask) * size + (static_cast<std::size_t>(-kx) & mask);
    const std::complex<double> a = modes.h0[here], b = std::conj(modes.h0[there]);
    const std::complex<double> cosine = a + b, sine = std::complex<double>(0, 1) * (b - a);
    const double streams[4] = {cosine.real(), cosine.imag(), sine.real(), sine.imag()};
    const auto lanes = static_cast<std::size_t>(state.kernels->lanes);
    float* record = state.records.get() + index * native::record_streams * lanes;
    for (std::size_t i = 0; i < 4; ++i)
        record[i * lanes + lane] = static_cast<float>(streams[i]);
    std::memcpy(record + 4 * lanes + 2 * lane, &modes.rate[here], sizeof(Rate));
    const double k = std::hypot(kx, ky) * modes.spec.wavenumber_step_radpm();
    state.over_k[index * lanes + lane] =
        static_cast<float>(k > 0 ? modes.displacement_over_k(k) : 0.0);
    state.omega[index * lanes + lane] = static_cast<float>(omega_from_rate(modes.rate[here]));
}

void write_records(const CascadeModes& modes, std::size_t records, TransformState& state) {
    const int lanes = state.kernels->lanes;
    const std::size_t lane_floats = records * static_cast<std::size_t>(lanes);
    state.records = allocate_floats(lane_floats * native::record_streams);
    state.over_k = allocate_floats(lane_floats);
    state.omega = allocate_floats(lane_floats);
    int first_kx = 0;
    for (const Block& block : state.blocks) {
        std::size_t index = block.first;
        for (int ky = -block.reach; ky <= block.reach; ++ky, ++index)
            for (int lane = 0; lane < lanes; ++lane)
                write_mode(modes, first_kx + lane, ky, index, static_cast<std::size_t>(lane),
                           state);
        first_kx += lanes;
    }
}

/// Twiddles [k1][n2], powers of ky, and weight kx^p of every field: they depend on the size and the
/// lattice only.
void write_tables(const CascadeSpec& spec, TransformState& state) {
    const auto size = static_cast<std::size_t>(spec.size);
    state.tables = allocate_floats((2 + 3 + linear_field_count) * size);
    float* next = state.tables.get();
    const auto add_table = [&](auto value) -> const float* {
        float* table = next;
        for (int i = 0; i < spec.size; ++i)
            table[i] = static_cast<float>(value(i));
        next += size;
        return table;
    };
    const int r2 = state.kernels->r2;
    const auto angle = [&](int i) {
        const int row = i / r2, column = i % r2;
        return 2 * std::numbers::pi * (row * column) / spec.size;
    };
    state.plan.cos = add_table([&](int i) { return std::cos(angle(i)); });
    state.plan.sin = add_table([&](int i) { return std::sin(angle(i)); });
    const auto k_to = [&](int i, int power) {
        return std::pow(signed_index(i, spec.size) * spec.wavenumber_step_radpm(), power);
    };
    for (int power = 0; power < 3; ++power)
        state.ky[power] = add_table([&](int i) { return k_to(i, power); });
    for (const Field field : linear_fields) {
        const FieldInfo& row = info(field);
        const int power = native::recipe(row).kx_power;
        state.scale[static_cast<std::size_t>(field)] =
            power == 0 && row.weight == 1.0
                ? nullptr
                : add_table([&](int i) { return row.weight * k_to(i, power); });
    }
}

Result<void> validate(const CascadeModes& modes) {
    const int size = modes.spec.size;
    if (size < NativeTransform::smallest_size || size > NativeTransform::largest_size ||
        !std::has_single_bit(static_cast<unsigned>(size)))
        return Error{
            fmt::format("cascade of {:g} m: size {}; the native device makes powers of two "
                        "from {} to {} (of 2048 a Vulkan device does)",
                        modes.spec.length_m, size, NativeTransform::smallest_size,
                        NativeTransform::largest_size)};
    const auto modes_wanted = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    if (modes.h0.size() != modes_wanted || modes.rate.size() != modes_wanted)
        return Error{fmt::format("native synthesis: {} amplitudes and {} rates for size {}, "
                                 "expected {} of each",
                                 modes.h0.size(), modes.rate.size(), size, modes_wanted)};
    return {};
}

} // namespace

native::FieldRecipe native::recipe(const FieldInfo& info) {
    const auto at = [&](native::Source source, int ky_power, int kx_power) {
        return FieldRecipe{(source + (info.time_rate ? 2 : 0)) * 3 + ky_power, kx_power};
    };
    using native::source_h, native::source_h_over_k;
    switch (info.basis) {
    case Basis::one:
        return at(source_h, 0, 0);
    case Basis::kx:
        return at(source_h, 0, 1);
    case Basis::ky:
        return at(source_h, 1, 0);
    case Basis::kx_over_k:
        return at(source_h_over_k, 0, 1);
    case Basis::ky_over_k:
        return at(source_h_over_k, 1, 0);
    case Basis::kxx_over_k:
        return at(source_h_over_k, 0, 2);
    case Basis::kyy_over_k:
        return at(source_h_over_k, 2, 0);
    case Basis::kxy_over_k:
        return at(source_h_over_k, 1, 1);
    }
    SEAWAY_CHECK(false, "a basis without a recipe");
}

NativeTransform::NativeTransform(std::unique_ptr<const TransformState> state)
    : state_(std::move(state)) {}
NativeTransform::NativeTransform(NativeTransform&&) noexcept = default;
NativeTransform& NativeTransform::operator=(NativeTransform&&) noexcept = default;
NativeTransform::~NativeTransform() = default;

int NativeTransform::size() const {
    return state_->kernels->size;
}

Result<NativeTransform> NativeTransform::create(const CascadeModes& modes, Choppiness choppiness,
                                                Instructions instructions) {
    SEAWAY_TRY(validate(modes));
    auto state = std::make_unique<TransformState>();
    state->kernels = find_kernels(instructions, modes.spec.size);
    SEAWAY_CHECK(state->kernels != nullptr, "a size without kernels");
    state->choppiness = choppiness;
    std::size_t records = 0;
    state->blocks = find_blocks(modes, state->kernels->lanes, records);
    write_records(modes, records, *state);
    write_tables(modes.spec, *state);
    return NativeTransform(std::move(state));
}

} // namespace seaway::sea
