// SPDX-License-Identifier: Apache-2.0
// The Synthesizer for `--device native`: keyframes from the CPU, with SIMD and threads.
#pragma once

#include <optional>
#include <vector>

#include "sea/native/native_runner.h"
#include "sea/native/native_transform.h"
#include "server/device/synthesizer.h"

namespace seaway::server {

class SpareBuffers;

class NativeSynthesizer final : public Synthesizer {
  public:
    /// Threads including the caller; 0: `usable_processors()`.
    explicit NativeSynthesizer(int threads = 0);

    std::string description() const override;
    Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) override;
    Result<FoamMapPtr> open_foam(int size, const FoamMap* from) override;
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override;
    Result<std::vector<SynthesisStage>> stages(const KeyframeRequest& request) override;
    SynthesisCounters counters() const override { return counters_; }
    void trim() override;

  private:
    /// `strains`: a keyframe that has them, where the turn looks at any.
    void take_turn(const FoamTurn& turn, const sea::Keyframe& strains, sea::Keyframe& keyframe);
    /// Without values.
    NewKeyframePtr keyframe(const KeyframeRequest& request, sea::FieldSet fields) const;

    sea::NativeRunner runner_;
    sea::RealizationPtr sea_;
    std::uint32_t epoch_ = 0;
    std::vector<std::optional<sea::NativeTransform>> cascades_;
    std::shared_ptr<SpareBuffers> spare_;
    SynthesisCounters counters_;
};

} // namespace seaway::server
