// SPDX-License-Identifier: Apache-2.0
#include "client/window/seen_sea.h"

#include "client/view/sea/sea_source.h"

namespace seaway::client {

Result<std::optional<SeenSea::Moment>> StreamedSea::now() {
    const std::shared_ptr<Client> client = feed_.client();
    if (!client)
        return std::optional<Moment>();
    const sea::TimeUs now_us = client->now_us();
    Result<SeaFrame> frame = held_sea_frame(*client, now_us);
    if (!frame)
        return std::optional<Moment>();
    Result<LocalSurface> surface = client->surface(now_us);
    if (!surface)
        return std::optional<Moment>();
    return std::optional<Moment>(
        {std::move(*frame), client->sea_state(now_us),
         std::make_shared<const ClientPoints>(client, std::move(*surface))});
}

SeenSea::Counts StreamedSea::counts() const {
    const FeedStatus status = feed_.status();
    return {status.keyframes, status.bytes};
}

std::vector<PanelRow> StreamedSea::connection(std::optional<double> stale_s) const {
    return connection_rows(url_, feed_.status(), feed_.client().get(), stale_s);
}

std::vector<PanelRow> StreamedSea::rates(double keyframes_hz, double bytes_hz,
                                         double frames_hz) const {
    return rate_rows(feed_.status(), keyframes_hz, bytes_hz, frames_hz);
}

} // namespace seaway::client
