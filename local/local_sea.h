// SPDX-License-Identifier: Apache-2.0
// LocalSea: the sea of a scene, made on the device that draws it (decision 0059). Keyframes stand where the synthesizer
// computed them, foam among them, and the renderer reads them there: no map goes through the CPU.
//
//     SEAWAY_TRY_LET(server::RunningSeaPtr scene, read_local_scene("gale.toml"));     // what is wrong with the file
//     SEAWAY_TRY_LET(std::unique_ptr<LocalSea> sea, LocalSea::create(scene, device)); // what is wrong with the device
//     SEAWAY_TRY_LET(client::SeaFrame frame, sea->at(time_us));
//
// Points are answered by the exact sum of the waves. For one thread, which also draws.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "client/rebuilt/rebuilt_sea.h"
#include "client/view/sea/sea_source.h"
#include "client/view/view_options.h"
#include "client/window/seen_sea.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/running_sea.h"

namespace seaway::local {

/// Realises the scene. An error names the file and what is wrong with it, or what of it a server alone can do: a
/// timetable, stylised sines, a scene that answers questions only, more cascades than can be drawn.
Result<server::RunningSeaPtr> read_local_scene(const std::string& path);

class LocalSea final : public client::SeaSource {
  public:
    /// `sea` as read_local_scene() gave it. An error: the device has no kernels for its tiles, or too little memory.
    static Result<std::unique_ptr<LocalSea>> create(server::RunningSeaPtr sea,
                                                    std::shared_ptr<gpu::Device> device);

    sea::TimeUs now_us() const override { return 0; }
    /// Makes the keyframes that the last frame did not have, and walks their foam: times that grow are cheap, the
    /// first frame of a gale takes some hundred ticks of foam. An error is the device's.
    Result<client::SeaFrame> at(sea::TimeUs time_us) override;
    std::string scene_at(sea::TimeUs) const override { return state_->scene; }

    const client::SeaStatePtr& state() const { return state_; }
    /// Its waves.
    const client::RebuiltSeaPtr& waves() const { return waves_; }
    server::SynthesisCounters counters() const { return device_->counters(); }
    std::string description() const { return device_->description(); }

  private:
    LocalSea(server::RunningSeaPtr sea, std::unique_ptr<server::VulkanSynthesizer> device);
    /// Keyframes of one time of each of some cascades.
    struct Wanted {
        std::size_t cascade;
        sea::TimeUs time_us;
        client::StandingKeyframePtr* to;
    };
    Result<void> make(const std::vector<Wanted>& wanted);

    const server::RunningSeaPtr sea_;
    const client::SeaStatePtr state_;
    const client::RebuiltSeaPtr waves_;
    const std::unique_ptr<server::VulkanSynthesizer> device_;
    const sea::FieldSet fields_;
    server::FoamMaps foam_;
    std::vector<client::CascadeFrame::Standing> held_; ///< of the last frame, a cascade each
};

/// The same in a window, from options.time_s on; `sea` as read_local_scene() gave it.
client::OpenSea open_in_a_window(server::RunningSeaPtr sea, const client::ViewOptions& options);

} // namespace seaway::local
