// SPDX-License-Identifier: Apache-2.0
// A synthesizer that outlives its device: when one fails, it is made anew with the same sea, and
// what was asked is asked again, a bounded number of times. Counters go on over rebuilds; foam maps are lost.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/device/synthesizer.h"

namespace seaway::server {

/// Which device a factory is to make.
enum class Making {
    the_same,      ///< as before: what it lacks may be there again later
    what_there_is, ///< any other where it cannot be made and the choice is the server's: at the start, and when no further try follows
    another,       ///< likewise, of one that can be made and fails at its work
};

/// Makes a device that holds the sea already. What it throws where the system gives it no thread (std::system_error) is for whoever
/// starts; later it is a try that failed.
using SynthesizerFactory = std::function<Result<std::unique_ptr<Synthesizer>>(
    const sea::RealizationPtr& sea, std::uint32_t epoch, Making making)>;

/// Of one call of synthesize(), each after a pause: a GPU that is reset, or whose driver is loaded anew, is away for some seconds.
inline constexpr std::array<std::chrono::milliseconds, 3> device_rebuild_pauses{
    std::chrono::milliseconds(0), std::chrono::milliseconds(500), std::chrono::milliseconds(3000)};
inline constexpr int device_rebuilds_max = static_cast<int>(device_rebuild_pauses.size());

class RebuiltSynthesizer final : public Synthesizer {
  public:
    using Warn = std::function<void(const std::string& why)>;

    /// Makes the first device. `warn` is told of each that fails, and once a minute of memory that is lacking.
    static Result<std::unique_ptr<RebuiltSynthesizer>>
    start(SynthesizerFactory factory, sea::RealizationPtr sea, std::uint32_t epoch, Warn warn);

    std::string description() const override;
    /// Where there is no device, or it fails, what is asked for next makes one with this sea.
    Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) override;

    /// An error is that of the last of device_rebuilds_max + 1 attempts; or DeviceError::foam_lost: there is a device
    /// again, or what is asked for next makes one; no more often than device_rebuilds_max times without foam in between.
    Result<FoamMapPtr> open_foam(int size, const FoamMap* from) override;
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override;

    SynthesisCounters counters() const override;
    void trim() override {
        if (device_)
            device_->trim();
    }
    std::uint64_t rebuilds() const { return rebuilds_; }

  private:
    RebuiltSynthesizer(SynthesizerFactory factory, Warn warn)
        : factory_(std::move(factory)), warn_(std::move(warn)) {}
    Result<void> rebuild(Making making);
    /// After a pause, the longer the more tries there were in a row; `failed_at_work`: one that had been made meanwhile.
    Result<void> try_again(int tries, bool failed_at_work);
    void let_go();
    void warn_of_memory(const Error& why);
    /// Work on a device, or on the next one; `on_foam`: there are maps in it that only this one has.
    template <class T, class Work>
    Result<T> attempt(bool on_foam, const Work& work);

    const SynthesizerFactory factory_;
    const Warn warn_;
    sea::RealizationPtr sea_;
    std::uint32_t epoch_ = 0;
    std::unique_ptr<Synthesizer> device_; ///< null after a rebuild that failed
    SynthesisCounters before_;            ///< of devices that are gone
    std::uint64_t rebuilds_ = 0;
    std::uint64_t refused_ = 0; ///< for want of memory, since that was warned of
    std::optional<std::chrono::steady_clock::time_point> warned_of_memory_;
    int foam_losses_ = 0; ///< in a row, without foam that was made in between
};

} // namespace seaway::server
