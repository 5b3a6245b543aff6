// SPDX-License-Identifier: Apache-2.0
// Prints a hash over the bits of a realised sea of every kind of system, and of its exact sum, for same_bits.sh.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include "sea/basics/field.h"
#include "sea/waves/realize.h"
#include "sea/waves/reference.h"

namespace {

using namespace seaway::sea;

/// FNV-1a over the bytes.
class Hash {
  public:
    template <class T>
    void add(const T& value) {
        unsigned char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof(T));
        for (const unsigned char byte : bytes)
            state_ = (state_ ^ byte) * 0x100000001B3ull;
    }
    std::uint64_t value() const { return state_; }

  private:
    std::uint64_t state_ = 0xCBF29CE484222325ull;
};

SeaState every_system() {
    SeaState sea;
    sea.seed = 42;
    sea.depth_m = 35.0;
    sea.short_wave_fade_m = 0.05;
    for (const SpreadingKind kind :
         {SpreadingKind::cos2, SpreadingKind::cos2s, SpreadingKind::mitsuyasu,
          SpreadingKind::hasselmann, SpreadingKind::donelan_banner})
        for (const SpectrumKind spectrum :
             {SpectrumKind::jonswap, SpectrumKind::tma, SpectrumKind::pierson_moskowitz,
              SpectrumKind::phillips}) {
            WindSea wind;
            wind.spectrum = spectrum;
            wind.wind_speed_10m_mps = 7.3;
            wind.fetch_m = 81e3;
            wind.towards_rad = 0.3;
            wind.spreading = {kind, 6.5, 0.2, 0.1};
            sea.systems.emplace_back(wind);
        }
    Swell swell;
    swell.significant_height_m = 1.7;
    swell.peak_period_s = 7.9;
    swell.gamma = 4.4;
    sea.systems.emplace_back(swell);
    MeasuredSea measured;
    measured.spectrum = std::make_shared<const MeasuredSpectrum>(
        *parse_measured("f_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n0.1,0.02,3,0.4,0.5,0.1,0.2\n"
                        "0.2,0.18,1,0.3,0.3,0.1,0.1\n",
                        "hash"));
    sea.systems.emplace_back(measured);
    SineRamps ramps;
    ramps.length_m = 400.0;
    sea.systems.emplace_back(ramps);
    return sea;
}

} // namespace

int main() {
    const std::vector<CascadeSpec> cascades{{400.0, 128}, {71.0, 128}, {13.0, 64}};
    const auto sea = std::make_shared<const Realization>(*realize(every_system(), cascades));
    Hash hash;
    for (const CascadeModes& modes : sea->cascades)
        for (std::size_t i = 0; i < modes.h0.size(); ++i) {
            hash.add(modes.h0[i].real());
            hash.add(modes.h0[i].imag());
            hash.add(modes.rate[i]);
        }
    const LagrangianPoint point = DirectSum(sea).at(123.4, -56.7, 8'901'234);
    for (const Field field : linear_fields)
        hash.add(value_of(point, field));
    std::printf("%016llx\n", static_cast<unsigned long long>(hash.value()));
}
