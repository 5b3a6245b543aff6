// SPDX-License-Identifier: Apache-2.0
// SeenSea: the sea that a window shows. A server's is here; one that this process makes is the program's (local/).
//
// One at a time; for the thread that made it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/view/sea/sea_frame.h"
#include "client/window/feed.h"
#include "client/window/model.h"
#include "client/window/points.h"

namespace seaway::client {

class SeenSea {
  public:
    struct Moment {
        SeaFrame frame;
        SeaStatePtr state; ///< what is said of the sea
        PointsPtr points;  ///< of it, around this time
    };
    /// What has come or been made since the start.
    struct Counts {
        std::uint64_t keyframes = 0, bytes = 0;
    };

    virtual ~SeenSea() = default;
    /// The sea of now; nothing: it is not held. An error: the device is lost.
    virtual Result<std::optional<Moment>> now() = 0;
    /// Where the sea is from, in the window's title.
    virtual const std::string& name() const = 0;
    /// Why there is nothing to show; empty: no reason is known.
    virtual std::string reason() const = 0;
    virtual Counts counts() const = 0;
    virtual std::vector<PanelRow> connection(std::optional<double> stale_s) const = 0;
    virtual std::vector<PanelRow> rates(double keyframes_hz, double bytes_hz,
                                        double frames_hz) const = 0;
};

/// Opens the sea of a window whose pictures are drawn on this device.
using OpenSea = std::function<Result<std::unique_ptr<SeenSea>>(std::shared_ptr<gpu::Device>)>;

class StreamedSea final : public SeenSea {
  public:
    StreamedSea(const ConnectOptions& connect, const TileLimits& limits)
        : url_(connect.url), feed_(connect, limits) {}

    Result<std::optional<Moment>> now() override;
    const std::string& name() const override { return url_; }
    std::string reason() const override { return feed_.status().reason; }
    Counts counts() const override;
    std::vector<PanelRow> connection(std::optional<double> stale_s) const override;
    std::vector<PanelRow> rates(double keyframes_hz, double bytes_hz,
                                double frames_hz) const override;

  private:
    const std::string url_;
    Feed feed_;
};

} // namespace seaway::client
