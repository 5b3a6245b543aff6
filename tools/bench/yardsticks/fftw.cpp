// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/yardsticks/fftw.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <span>
#include <vector>

#include <dlfcn.h>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/thread_pool.h"

namespace seaway::bench {

namespace {

using Clock = std::chrono::steady_clock;
constexpr const char* library = "libfftw3f.so.3";
constexpr unsigned measure = 0; ///< FFTW_MEASURE, fftw3.h
constexpr int threads = 2;

using Complex = float[2];
using PlanHandle = void*;

struct Functions {
    PlanHandle (*plan)(int, int, Complex*, float*, unsigned) = nullptr;
    void (*execute)(PlanHandle, Complex*, float*) = nullptr;
    void (*destroy)(PlanHandle) = nullptr;
    void* (*allocate)(std::size_t) = nullptr;
    void (*free)(void*) = nullptr;
    const char* version = nullptr;
};

class Loaded final : public Fftw {
  public:
    static Result<std::unique_ptr<Fftw>> open() {
        std::unique_ptr<Loaded> made(new Loaded);
        made->handle_ = dlopen(library, RTLD_NOW | RTLD_LOCAL);
        if (made->handle_ == nullptr)
            return Error{fmt::format("{} is not there", library)};
        Functions& f = made->functions_;
        const bool all = made->take(f.plan, "fftwf_plan_dft_c2r_2d") &&
                         made->take(f.execute, "fftwf_execute_dft_c2r") &&
                         made->take(f.destroy, "fftwf_destroy_plan") &&
                         made->take(f.allocate, "fftwf_malloc") &&
                         made->take(f.free, "fftwf_free") && made->take(f.version, "fftwf_version");
        if (!all)
            return Error{fmt::format("{} has not what is asked of it", library)};
        return std::unique_ptr<Fftw>(std::move(made));
    }
    ~Loaded() override {
        for (auto& [size, plans] : plans_)
            for (const Plan& plan : plans)
                release(plan);
        if (handle_ != nullptr)
            dlclose(handle_);
    }
    std::string name() const override {
        return fmt::format("{}, {} threads", functions_.version, threads);
    }

    Result<double> seconds(int size, int count) override {
        SEAWAY_TRY(make_plans(size));
        std::array<double, threads> took_s{};
        struct Work {
            const Functions& functions;
            std::span<const Plan> plans;
            int count;
            std::span<double, threads> took_s;
        };
        const Work work{functions_, plans_[size], count, took_s};
        const Phase phase{[](const void* context, int thread, int) {
                              const Work& own = *static_cast<const Work*>(context);
                              const Plan& plan = own.plans[static_cast<std::size_t>(thread)];
                              for (int i = thread; i < own.count; i += threads) {
                                  std::copy_n(plan.kept.begin(), plan.kept.size(),
                                              reinterpret_cast<float*>(plan.spectrum));
                                  const auto start = Clock::now();
                                  own.functions.execute(plan.handle, plan.spectrum, plan.map);
                                  own.took_s[static_cast<std::size_t>(thread)] +=
                                      seconds_since(start);
                              }
                          },
                          &work, threads};
        pool_.run({&phase, 1});
        return *std::ranges::max_element(took_s);
    }

  private:
    struct Plan {
        PlanHandle handle;
        Complex* spectrum;
        float* map;
        std::vector<float>
            kept; ///< what the spectrum is filled with anew: the transform destroys it
    };

    Loaded() = default;
    template <class Symbol>
    bool take(Symbol& place, const char* symbol) {
        place = reinterpret_cast<Symbol>(dlsym(handle_, symbol));
        return place != nullptr;
    }
    void release(const Plan& plan) const {
        if (plan.handle != nullptr)
            functions_.destroy(plan.handle);
        functions_.free(plan.spectrum);
        functions_.free(plan.map);
    }
    Result<void> make_plans(int size) {
        std::vector<Plan>& plans = plans_[size];
        const auto n = static_cast<std::size_t>(size);
        const std::size_t modes = n * (n / 2 + 1);
        while (plans.size() < threads) {
            auto* spectrum = static_cast<Complex*>(functions_.allocate(modes * sizeof(Complex)));
            auto* map = static_cast<float*>(functions_.allocate(n * n * sizeof(float)));
            Plan plan{nullptr, spectrum, map, std::vector<float>(2 * modes, 1e-3f)};
            if (spectrum != nullptr && map != nullptr)
                plan.handle = functions_.plan(size, size, spectrum, map, measure);
            if (plan.handle == nullptr) {
                release(plan);
                return Error{fmt::format("{} has no plan of size {}", library, size)};
            }
            plans.push_back(std::move(plan));
        }
        return {};
    }

    void* handle_ = nullptr;
    Functions functions_;
    std::map<int, std::vector<Plan>> plans_;
    ThreadPool pool_{threads};
};

} // namespace

Result<std::unique_ptr<Fftw>> Fftw::open() {
    return Loaded::open();
}

} // namespace seaway::bench
