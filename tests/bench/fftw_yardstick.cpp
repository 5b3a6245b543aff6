// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/fftw_yardstick.h"

#include <cmath>

#include "base/check.h"

namespace seaway::bench {

struct FftwYardstick::Modes {
    std::vector<float> cosine, sine, over_k, wavenumber;
    std::vector<std::uint64_t> rate;
    PlainModes plain;

    explicit Modes(const sea::CascadeModes& modes) : rate(modes.rate) {
        const auto n = static_cast<std::size_t>(modes.spec.size);
        const double step = modes.spec.wavenumber_step_radpm();
        const auto k_at = [&](std::size_t i) {
            return sea::signed_index(static_cast<int>(i), modes.spec.size) * step;
        };
        for (std::size_t iy = 0; iy < n; ++iy) {
            wavenumber.push_back(static_cast<float>(k_at(iy)));
            for (std::size_t ix = 0; ix < n; ++ix) {
                const auto a = modes.h0[iy * n + ix];
                const auto b = std::conj(modes.h0[(n - iy) % n * n + (n - ix) % n]);
                const auto p = a + b, q = std::complex<double>(0, 1) * (b - a);
                const double k = std::hypot(k_at(ix), k_at(iy));
                for (double v : {p.real(), p.imag()})
                    cosine.push_back(static_cast<float>(v));
                for (double v : {q.real(), q.imag()})
                    sine.push_back(static_cast<float>(v));
                over_k.push_back(static_cast<float>(k > 0 ? modes.displacement_over_k(k) : 0));
            }
        }
        plain = {modes.spec.size, cosine.data(),     sine.data(),
                 over_k.data(),   wavenumber.data(), rate.data()};
    }
};

struct FftwYardstick::Step {
    FftwYardstick* yardstick;
    std::size_t cascade;
    sea::TimeUs t_us;

    float* field(int index) const { return const_cast<float*>(yardstick->packed(cascade, index)); }
    void evolve(int begin, int end) const {
        float* const out[packed_fields] = {field(0), field(1), field(2), field(3)};
        const EvolveRow evolve_row =
            yardstick->program_ == FftwProgram::plain ? evolve_row_plain : evolve_row_vectorised;
        for (int iy = begin; iy < end; ++iy)
            evolve_row(yardstick->modes_[cascade]->plain, static_cast<std::uint64_t>(t_us), iy,
                       out);
    }
};

FftwYardstick::FftwYardstick(FftwProgram program, std::span<const sea::CascadeModes> cascades)
    : program_(program), size_(cascades[0].spec.size) {
    for (const sea::CascadeModes& modes : cascades)
        modes_.push_back(std::make_unique<Modes>(modes));
    const std::size_t points = static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_);
    const std::size_t floats = cascades.size() * packed_fields * points * 2;
    packed_.reset(fftwf_alloc_real(floats));
    planes_.resize(floats);
    const int n[2] = {size_, size_};
    const int distance = size_ * size_;
    auto* data = reinterpret_cast<fftwf_complex*>(packed_.get());
    const auto plan = [&](int fields) {
        return fftwf_plan_many_dft(2, n, fields, data, nullptr, 1, distance, data, nullptr, 1,
                                   distance, FFTW_BACKWARD, FFTW_MEASURE);
    };
    if (program == FftwProgram::plain) {
        SEAWAY_CHECK(fftwf_init_threads() != 0, "FFTW threads");
        fftwf_plan_with_nthreads(2);
        batch_ = plan(packed_fields);
        fftwf_plan_with_nthreads(1);
    } else {
        half_ = plan(packed_fields / 2);
    }
}

FftwYardstick::~FftwYardstick() {
    if (half_)
        fftwf_destroy_plan(half_);
    if (batch_)
        fftwf_destroy_plan(batch_);
}

const float* FftwYardstick::packed(std::size_t cascade, int field) const {
    const std::size_t points = static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_);
    return packed_.get() + (cascade * packed_fields + static_cast<std::size_t>(field)) * points * 2;
}

void FftwYardstick::evolve_rows(const void* context, int chunk, int) {
    const Step& step = *static_cast<const Step*>(context);
    const int half = step.yardstick->size_ / 2;
    step.evolve(chunk * half, (chunk + 1) * half);
}

void FftwYardstick::transform_half(const void* context, int chunk, int) {
    const Step& step = *static_cast<const Step*>(context);
    auto* data = reinterpret_cast<fftwf_complex*>(step.field(chunk * packed_fields / 2));
    fftwf_execute_dft(step.yardstick->half_, data, data);
}

void FftwYardstick::split_half(const void* context, int chunk, int) {
    const Step& step = *static_cast<const Step*>(context);
    FftwYardstick& self = *step.yardstick;
    const std::size_t points =
        static_cast<std::size_t>(self.size_) * static_cast<std::size_t>(self.size_);
    for (int i = chunk * packed_fields / 2; i < (chunk + 1) * packed_fields / 2; ++i) {
        float* plane = self.planes_.data() +
                       (step.cascade * packed_fields + static_cast<std::size_t>(i)) * 2 * points;
        const auto split_rows =
            self.program_ == FftwProgram::plain ? split_rows_plain : split_rows_vectorised;
        split_rows(step.field(i), plane, plane + points, points);
    }
}

void FftwYardstick::run(sea::TimeUs t_us, bool planar) {
    std::vector<Step> steps;
    for (std::size_t cascade = 0; cascade < modes_.size(); ++cascade)
        steps.push_back({this, cascade, t_us});
    std::vector<Phase> phases;
    const auto add = [&](auto work, const Step& step, int after) {
        phases.push_back({work, &step, 2, after});
        return static_cast<int>(phases.size()) - 1;
    };
    for (const Step& step : steps) {
        int last = add(evolve_rows, step, -1);
        if (program_ == FftwProgram::plain) {
            pool_.run(phases);
            phases.clear();
            auto* data = reinterpret_cast<fftwf_complex*>(step.field(0));
            fftwf_execute_dft(batch_, data, data);
            last = -1;
        } else {
            last = add(transform_half, step, last);
        }
        if (planar)
            add(split_half, step, last);
    }
    pool_.run(phases);
}

} // namespace seaway::bench
